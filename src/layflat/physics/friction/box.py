"""Dry friction that holds exactly, as impulses over one step (no regularisation, no creep).

| symbol | meaning | unit |
|---|---|---|
| p | momentum of a joint (M v)_i that the step would end with, were there no friction | kg m2 rad/s |
| M | mass matrix (M_11, M_12, M_22) | kg m2 |
| low, high | least and greatest impulse of friction in this step: -B and B, where B is torque x step | N m s |
| J | impulse of friction | N m s |
| v | velocity after the step | rad/s |

Find J within low and high such that each joint either stands still, or slides with J = low forward, with J = high back,
where M v = p + J. This is the optimality condition of a convex quadratic in J over a box; for two joints the exact
minimiser is closed-form (see docs/derivations.md): minimise over J_2 first, clip J_1, then solve for J_2 again. The
minimum can't have more kinetic energy than p has, whatever B is: friction only takes. Where friction is known, low is
high.
"""

from layflat.jit import law
from layflat.lanes import select


@law
def brake_one(M, p, low, high):
    """Velocity after friction, and the impulse, of a single joint. The velocity of a held joint is exactly 0."""
    J = min(max(-p, low), high)
    return (p + J) / M, J


@law
def brake_two(M_11, M_12, M_22, p_1, p_2, low_1, low_2, high_1, high_2):
    """Velocities after friction, and the impulses, of two coupled joints: (v_1, v_2, J_1, J_2)."""
    per_det = 1.0 / (M_11 * M_22 - M_12 * M_12)
    J_2 = min(max(-p_2, low_2), high_2)
    needed_1 = (M_12 / M_22) * (p_2 + J_2) - p_1
    J_1 = min(max(needed_1, low_1), high_1)
    needed_2 = (M_12 / M_11) * (p_1 + J_1) - p_2
    J_2 = min(max(needed_2, low_2), high_2)
    end_1, end_2 = p_1 + J_1, p_2 + J_2
    v_1 = select(needed_1 == J_1, 0.0, (M_22 * per_det) * end_1 - (M_12 * per_det) * end_2)
    v_2 = select(needed_2 == J_2, 0.0, (M_11 * per_det) * end_2 - (M_12 * per_det) * end_1)
    return v_1, v_2, J_1, J_2
