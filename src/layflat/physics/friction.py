"""Coulomb friction that holds exactly, as impulses over one step (no regularisation, no creep).

| symbol | meaning | unit |
|---|---|---|
| v | joint velocity that the step would end with, were there no friction | rad/s |
| M, W | mass matrix (M_11, M_12, M_22) and its inverse | kg m2, 1/(kg m2) |
| B | greatest impulse of the brake in this step: torque x step | N m s |
| J | impulse of the brake | N m s |

Find J with |J| <= B such that each joint either stands still, or slides with J = -B sign(v). This is the optimality
condition of a convex quadratic in J over a box; for two joints the exact minimiser is closed-form (see
docs/derivations.md): minimise over J_2 first, clip J_1, then solve for J_2 again.
"""

from layflat.jit import law


@law
def brake_one(M, v, B):
    """Velocity after friction, and the impulse, of a single joint. The velocity of a held joint is exactly 0."""
    J = min(max(-M * v, -B), B)
    return (0.0 if abs(M * v) <= B else v + J / M), J


@law
def brake_two(M_11, M_12, M_22, v_1, v_2, B_1, B_2):
    """Velocities after friction, and the impulses, of two coupled joints: (v_1, v_2, J_1, J_2)."""
    per_det = 1.0 / (M_11 * M_22 - M_12 * M_12)
    W_11, W_12, W_22 = M_22 * per_det, -M_12 * per_det, M_11 * per_det
    J_2 = min(max(-(M_12 * v_1 + M_22 * v_2), -B_2), B_2)
    free_1 = -(v_1 + W_12 * J_2) * (1.0 / W_11)
    J_1 = min(max(free_1, -B_1), B_1)
    free_2 = -(v_2 + W_12 * J_1) * (1.0 / W_22)
    J_2 = min(max(free_2, -B_2), B_2)
    end_1 = 0.0 if abs(free_1) <= B_1 else v_1 + W_11 * J_1 + W_12 * J_2
    end_2 = 0.0 if abs(free_2) <= B_2 else v_2 + W_12 * J_1 + W_22 * J_2
    return end_1, end_2, J_1, J_2
