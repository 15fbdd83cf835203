"""Dry friction over a step in which a joint may come to rest, turn round, or stay there.

| symbol | meaning | unit |
|---|---|---|
| M | mass matrix, upper triangle | kg m2 |
| p | momentum (M v)_i that the step would end with, were there no friction | kg m2 rad/s |
| u, w | velocities before and after the step | rad/s |
| B | greatest impulse of friction in this step: torque x step | N m s |
| low, high | least and greatest impulse of friction in this step: -B and B | N m s |
| S | the same of a joint that stands still at some instant of the step | N m s |
| J | impulse of friction | N m s |
| f | share of the step after which the first joint is at rest | 1 |

Friction turns with the velocity. Were it against the way at the end from the beginning of the step on, each turn would
leave an error of the order of B h. So what moves is taken to move on, against all of its friction, and what rests to
rest or to slip, as `brake_one`, `brake_two` and pivoting.py find. Where a joint would pass zero, the step is parted: up
to the first rest all is as it was taken to be, in proportion to time; from there the rest of the step is solved.
Friction takes energy in both parts.

Where friction depends on velocity, B is that of the velocity in the middle of the step, and a joint whose velocity
would pass zero in that rest is solved for once more with what holds it there, S.

One or two joints are solved in closed form: find J within low and high such that each joint either stands still, or
slides with J = low forward, with J = high back, where M v = p + J. This is the optimality condition of a convex
quadratic in J over a box; the exact minimiser is found (see docs/derivations.md): minimise over J_2 first, clip J_1,
then solve for J_2 again. The minimum can't have more kinetic energy than p has, whatever B is: friction only takes.
Where friction is known, low is high.
"""

from layflat.jit import composition, law
from layflat.lanes import anywhere, each, select, total
from layflat.physics.algebra import least, minus, times
from layflat.physics.friction.pivoting import brake_many


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


@composition
def _braked(M, p, u, low, high):
    # In closed form where there is one.
    if len(p) == 1:
        w, J = brake_one(M[0], p[0], low[0], high[0])
        return (w,), (J,)
    if len(p) == 2:
        w_1, w_2, J_1, J_2 = brake_two(M[0], M[1], M[2], p[0], p[1], low[0], low[1], high[0], high[1])
        return (w_1, w_2), (J_1, J_2)
    return brake_many(M, p, u, low, high)


@composition
def _keep(M, p, u, B, S):  # noqa: ARG001  (as `_slide`)
    return _braked(M, p, u, each(minus, B), B)


@law
def _passing(u, v, B, S):
    # The limit of a joint that goes from velocity u to v: that at rest if there is an instant of rest on the way.
    return select(u * v <= 0.0, S, B)


@composition
def _slide(M, p, u, B, S):
    v, _ = _keep(M, p, u, B, B)
    limits = each(_passing, u, v, B, S)
    return _keep(M, p, u, limits, limits)


@law
def _onwards(u, B, S):
    # Least and greatest impulse, as long as what moves moves on.
    most = select(u == 0.0, S, B)
    return select(u < 0.0, most, -most), select(u > 0.0, -most, most)


@law
def _comes_to_rest(u, w):
    return select((u < 0.0) & (w >= 0.0) | (u > 0.0) & (w <= 0.0), 1.0, 0.0)


@law
def _until_rest(u, onwards):
    rests = _comes_to_rest(u, onwards) > 0.0
    return select(rests, u / select(rests, u - onwards, 1.0), 1.0)


@law
def _at_rest(u, onwards, f):
    # Velocity when the first joint is at rest; 0 where none comes to rest, so that there is nothing left to solve.
    return select(_until_rest(u, onwards) <= f, 0.0, u + f * (onwards - u))


@law
def _later(before, p, begun, f):
    return before + (1.0 - f) * (p - begun)


@law
def _left(B, f):
    return (1.0 - f) * B


@law
def _either(f, parted, whole):
    return select(f < 1.0, parted, whole)


@law
def _both(f, J, K, B, S):
    most = max(B, S)
    return min(max(f * J + K, -most), most)


def _turning(solve):
    @composition
    def parted(M, p, u, B, S, onwards, J):
        """Velocities and impulses of a step that is parted where the first joint is at rest."""
        f = least(each(_until_rest, u, onwards))
        v = each(_at_rest, u, onwards, f)
        momentum = each(_later, times(M, v), p, times(M, u), f)
        w, K = solve(M, momentum, v, each(_left, B, f), each(_left, S, f))
        return each(_either, f, w, onwards), each(_both, f, J, K, B, S)

    @composition
    def rub(friction, M, p, u, B, S):  # noqa: ARG001  (by which the law is picked)
        """Return velocities after friction, and its impulses, tuples; a held joint's velocity is exactly 0."""
        low, high = each(_onwards, u, B, S)
        w, J = _braked(M, p, u, low, high)
        if anywhere(total(each(_comes_to_rest, u, w))):
            w, J = parted(M, p, u, B, S, w, J)
        return w, J

    return rub


keep, slide = _turning(_keep), _turning(_slide)
