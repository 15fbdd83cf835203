"""Dry friction over a step in which a joint may come to rest, turn round, or stay there.

| symbol | meaning | unit |
|---|---|---|
| M | mass matrix, upper triangle | kg m2 |
| p | momentum (M v)_i that the step would end with, were there no friction | kg m2 rad/s |
| u, w | velocities before and after the step | rad/s |
| B | greatest impulse of friction in this step: torque x step | N m s |
| S | the same of a joint that stands still at some instant of the step | N m s |
| J | impulse of friction | N m s |
| c | way that a joint goes before the step: 1, -1, or 0 at rest | 1 |
| f | share of the step after which the first joint is at rest | 1 |

Friction turns with the velocity. Were it against the way at the end from the beginning of the step on, each turn would
leave an error of the order of B h; so a step is parted where the first joint comes to rest, and each part is solved as
box.py and pivoting.py do. Friction takes energy in both parts. Velocities change evenly in a part, hence f.

Where friction depends on velocity, B is that of the velocity in the middle of the step, and a joint whose velocity
would pass zero is solved for once more with what holds it there, S.
"""

from layflat.jit import composition, law
from layflat.lanes import anywhere, each, select, total
from layflat.physics.algebra import least, times
from layflat.physics.friction.box import brake_one, brake_two
from layflat.physics.friction.pivoting import brake_many, way

FIRM = 1e30  # N m s: holds against anything
ONWARDS, BEFORE = range(2)  # what is solved for in a step that is parted, ahead of what comes after the rest


@composition
def _braked(M, p, u, B):
    # In closed form where there is one.
    if len(p) == 1:
        w, J = brake_one(M[0], p[0], B[0])
        return (w,), (J,)
    if len(p) == 2:
        w_1, w_2, J_1, J_2 = brake_two(M[0], M[1], M[2], p[0], p[1], B[0], B[1])
        return (w_1, w_2), (J_1, J_2)
    return brake_many(M, p, u, B)


@composition
def _keep(M, p, u, B, S):  # noqa: ARG001  (as `_slide`)
    return _braked(M, p, u, B)


@law
def _passing(u, v, B, S):
    # The limit of a joint that goes from velocity u to v: that at rest if there is an instant of rest on the way.
    return select(u * v <= 0.0, S, B)


@composition
def _slide(M, p, u, B, S):
    v, _ = _braked(M, p, u, B)
    return _braked(M, p, u, each(_passing, u, v, B, S))


@law
def _comes_to_rest(u, w):
    return select((u < 0.0) & (w >= 0.0) | (u > 0.0) & (w <= 0.0), 1.0, 0.0)


@law
def _pressed(p, c, B):
    return p - c * B


@law
def _firm(c):
    return select(c == 0.0, FIRM, 0.0)


@law
def _until_rest(u, onwards):
    rests = _comes_to_rest(u, onwards) > 0.0
    return select(rests, u / select(rests, u - onwards, 1.0), 1.0)


@law
def _part(before, push, f):
    return before + f * push


@law
def _share(B, f):
    return f * B


@law
def _difference(a, b):
    return a - b


@law
def _at_rest(u, onwards, w, f):
    return select((_until_rest(u, onwards) <= f) & (f < 1.0), 0.0, w)


@law
def _either(rests, f, parted, whole):
    return select((rests > 0.0) & (f < 1.0), parted, whole)


@law
def _both(J, K, B, S):
    most = max(B, S)
    return min(max(J + K, -most), most)


def _turning(solve):
    @composition
    def parted(M, p, u, B, S):
        """Velocities and impulses of a step that is parted where the first joint is at rest, and its share before."""
        one = 1.0 + 0.0 * total(u)
        # What moves moves on, what rests rests: up to where the first would come to rest.
        push, c = each(_difference, p, times(M, u)), each(way, u)
        momentum, begins, slides, f, onwards, J = each(_pressed, p, c, B), u, each(_firm, c), one, u, B
        holds, v, K = slides, u, B
        # A loop, or what solves would be compiled three times.
        for part in range(3):
            v, K = solve(M, momentum, begins, slides, holds)
            if part == ONWARDS:
                onwards, f = v, least(each(_until_rest, u, v))
                momentum = each(_part, times(M, u), push, f)
                slides, holds = each(_share, B, f), each(_share, S, f)
            elif part == BEFORE:
                begins, J = each(_at_rest, u, onwards, v, f), K
                momentum = each(_part, times(M, v), push, one - f)
                slides, holds = each(_share, B, one - f), each(_share, S, one - f)
        return v, each(_both, J, K, B, S), f

    @composition
    def rub(friction, M, p, u, B, S):  # noqa: ARG001  (by which the law is picked)
        """Return velocities after friction, and its impulses, tuples; a held joint's velocity is exactly 0."""
        w, J = solve(M, p, u, B, S)
        rests = total(each(_comes_to_rest, u, w))
        if anywhere(rests):
            after, impulses, f = parted(M, p, u, B, S)
            # Only of what comes to rest itself, whatever lies beside it.
            w, J = each(_either, rests, f, after, w), each(_either, rests, f, impulses, J)
        return w, J

    return rub


keep, slide = _turning(_keep), _turning(_slide)
