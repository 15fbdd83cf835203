"""Dry friction that holds exactly, as impulses over one step (no regularisation, no creep).

| symbol | meaning | unit |
|---|---|---|
| p | momentum of a joint (M v)_i that the step would end with, were there no friction | kg m2 rad/s |
| M | mass matrix (M_11, M_12, M_22) | kg m2 |
| B | greatest impulse of friction in this step: torque x step | N m s |
| J | impulse of friction | N m s |
| v | velocity after the step | rad/s |

Find J with |J| <= B such that each joint either stands still, or slides with J = -B sign(v), where M v = p + J. This is
the optimality condition of a convex quadratic in J over a box; for two joints the exact minimiser is closed-form (see
docs/derivations.md): minimise over J_2 first, clip J_1, then solve for J_2 again. Whatever B is, the minimum can't have
more kinetic energy than p has: friction only takes.
"""

from layflat.jit import law
from layflat.lanes import select


@law
def brake_one(M, p, B):
    """Velocity after friction, and the impulse, of a single joint. The velocity of a held joint is exactly 0."""
    J = min(max(-p, -B), B)
    return select(abs(p) <= B, 0.0, (p + J) / M), J


@law
def brake_two(M_11, M_12, M_22, p_1, p_2, B_1, B_2):
    """Velocities after friction, and the impulses, of two coupled joints: (v_1, v_2, J_1, J_2)."""
    per_det = 1.0 / (M_11 * M_22 - M_12 * M_12)
    J_2 = min(max(-p_2, -B_2), B_2)
    needed_1 = (M_12 / M_22) * (p_2 + J_2) - p_1
    J_1 = min(max(needed_1, -B_1), B_1)
    needed_2 = (M_12 / M_11) * (p_1 + J_1) - p_2
    J_2 = min(max(needed_2, -B_2), B_2)
    end_1, end_2 = p_1 + J_1, p_2 + J_2
    v_1 = select(abs(needed_1) <= B_1, 0.0, (M_22 * per_det) * end_1 - (M_12 * per_det) * end_2)
    v_2 = select(abs(needed_2) <= B_2, 0.0, (M_11 * per_det) * end_2 - (M_12 * per_det) * end_1)
    return v_1, v_2, J_1, J_2
