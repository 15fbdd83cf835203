"""Dry friction over a step in which a joint may come to rest, reverse, or stay at rest.

| symbol | meaning | unit |
|---|---|---|
| M | mass matrix, upper triangle | kg m2 |
| p | momentum (M v)_i after the step if there were no friction | kg m2 rad/s |
| u, w | velocities before and after the step | rad/s |
| B | maximum impulse of friction in this step: torque x step | N m s |
| low, high | minimum and maximum impulse of friction in this step: -B and B | N m s |
| S | B of a joint that is at rest at some instant of the step | N m s |
| J | impulse of friction | N m s |
| f | fraction of the step after which the first joint is at rest | 1 |

Friction reverses with the velocity. If it opposed the final direction from the beginning of the step on, each reversal
would leave an error of the order of B h. So a moving joint is first assumed to keep its direction, against all of its
friction, and a joint at rest to stay or to slip, as `brake_one`, `brake_two` and pivoting.py compute. Where a joint
would pass zero, the step is split: up to the first rest the assumed solution holds, in proportion to time; from there
the remaining step is solved. Friction dissipates energy in both parts.

Where friction depends on velocity, B is that at the velocity in the middle of the step, and a joint whose velocity
would pass zero in the remaining step is solved for once more with its holding impulse S.

One or two joints are solved in closed form: find J within low and high such that each joint either stands still, or
slides with J = low forward, with J = high back, where M v = p + J. This is the optimality condition of a convex
quadratic in J over a box; the exact minimiser is found (see docs/derivations.md): minimise over J_2 first, clip J_1,
then solve for J_2 again. The minimum can't have more kinetic energy than p has, whatever B is: friction only
dissipates. Where friction is known, low is high.
"""

from layflat.jit import composition, law
from layflat.lanes import anywhere, each, select, total
from layflat.physics.algebra import min_item, multiply_symmetric, negate
from layflat.physics.friction.pivoting import brake_many


@law
def brake_one(M, p, low, high):
    """Return the velocity after friction, and the impulse, of a single joint; if it is held, exactly 0 rad/s."""
    J = min(max(-p, low), high)
    return (p + J) / M, J


@law
def brake_two(M_11, M_12, M_22, p_1, p_2, low_1, low_2, high_1, high_2):
    """Return the velocities after friction, and the impulses, of two coupled joints: (v_1, v_2, J_1, J_2)."""
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


@composition
def _solve_bounded_friction(M, p, u, low, high):
    """Return velocities w and impulses J of all joints, tuples; in closed form for one or two joints."""
    if len(p) == 1:
        w, J = brake_one(M[0], p[0], low[0], high[0])
        return (w,), (J,)
    if len(p) == 2:
        w_1, w_2, J_1, J_2 = brake_two(M[0], M[1], M[2], p[0], p[1], low[0], low[1], high[0], high[1])
        return (w_1, w_2), (J_1, J_2)
    return brake_many(M, p, u, low, high)


@composition
def _solve_constant(M, p, u, B, S):  # noqa: ARG001  (signature of `_solve_varying`)
    return _solve_bounded_friction(M, p, u, each(negate, B), B)


@law
def _impulse_limit(u, v, B, S):
    """Return the maximum impulse of a joint whose velocity goes from u to v: that at rest if it passes zero."""
    return select(u * v <= 0.0, S, B)


@composition
def _solve_varying(M, p, u, B, S):
    """Return velocities and impulses of a step, with limit S in place of B for joints whose velocity passes zero."""
    v, _ = _solve_constant(M, p, u, B, B)
    limits = each(_impulse_limit, u, v, B, S)
    return _solve_constant(M, p, u, limits, limits)


@law
def _impulse_bounds(u, B, S):
    """Return minimum and maximum impulse while a moving joint keeps its direction."""
    limit = select(u == 0.0, S, B)
    return select(u < 0.0, limit, -limit), select(u > 0.0, -limit, limit)


@law
def _comes_to_rest(u, w):
    return select((u < 0.0) & (w >= 0.0) | (u > 0.0) & (w <= 0.0), 1.0, 0.0)


@law
def _fraction_until_rest(u, onwards):
    """Return the fraction of the step after which a velocity that goes from u to `onwards` is 0; 1 if it never is."""
    rests = _comes_to_rest(u, onwards) > 0.0
    return select(rests, u / select(rests, u - onwards, 1.0), 1.0)


@law
def _velocity_at_rest(u, onwards, f):
    """Return the velocity when the first joint is at rest; 0 where none is, so that nothing is left to solve."""
    return select(_fraction_until_rest(u, onwards) <= f, 0.0, u + f * (onwards - u))


@law
def _remaining_momentum(split, p, start, f):
    return split + (1.0 - f) * (p - start)


@law
def _remaining_impulse(B, f):
    return (1.0 - f) * B


@law
def _select_parted(f, parted, whole):
    return select(f < 1.0, parted, whole)


@law
def _total_impulse(f, J, K, B, S):
    """Return the impulse of a step: J in the fraction f of it, K in the rest, together within +-max(B, S), N m s."""
    limit = max(B, S)
    return min(max(f * J + K, -limit), limit)


def _build_solver(solve):
    """Return the law of friction over a step, for which `solve` computes the remaining step after the first rest."""

    @composition
    def parted(M, p, u, B, S, onwards, J):
        """Return velocities and impulses of a step that is split where the first joint comes to rest.

        `onwards` and J are the velocities and impulses if it is not split.
        """
        f = min_item(each(_fraction_until_rest, u, onwards))
        v = each(_velocity_at_rest, u, onwards, f)
        momentum = each(_remaining_momentum, multiply_symmetric(M, v), p, multiply_symmetric(M, u), f)
        w, K = solve(M, momentum, v, each(_remaining_impulse, B, f), each(_remaining_impulse, S, f))
        return each(_select_parted, f, w, onwards), each(_total_impulse, f, J, K, B, S)

    @composition
    def rub(friction, M, p, u, B, S):  # noqa: ARG001  (selects the law)
        """Return velocities after friction, and its impulses, tuples; a held joint's velocity is exactly 0."""
        low, high = each(_impulse_bounds, u, B, S)
        w, J = _solve_bounded_friction(M, p, u, low, high)
        if anywhere(total(each(_comes_to_rest, u, w))):
            w, J = parted(M, p, u, B, S, w, J)
        return w, J

    return rub


solve_constant_friction, solve_varying_friction = _build_solver(_solve_constant), _build_solver(_solve_varying)
