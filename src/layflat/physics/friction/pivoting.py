"""Dry friction of any number of coupled joints, which holds exactly, as impulses over one step.

| symbol | meaning | unit |
|---|---|---|
| M | mass matrix | kg m2 |
| p | momentum (M v)_i that the step would end with, were there no friction | kg m2 rad/s |
| low, high | least and greatest impulse of friction in this step | N m s |
| J | impulse of friction | N m s |
| w | velocity after the step | rad/s |
| c | how a joint is taken to go: 1 or -1 where it slides that way, 0 where it is held | 1 |

The problem of `brake_two` (turning.py) for more than two joints: M w = p + J, where a joint is held (w = 0, low <= J <=
high) or slides (forward with J = low, back with J = high). With c given it is linear; what then is against c changes
it: a joint that would slide the other way is held, one that is held by more than there is slides. From how the joints
went before the step one round mostly does. All that is against c changes at once, and where that goes on for `BLOCKS`
rounds, only the first of it, which comes to an end since M is positive definite (judice1994).
"""

from layflat.jit import composition, law
from layflat.lanes import anywhere, each, epsilon, gather, select, slots, total
from layflat.physics.algebra import times

BLOCKS, ROUNDS = 6, 60  # rounds in which all may change, and rounds at most
ROUNDING = 0.5e-12 * 2.0**52  # of what is between the impulses, in the last places of their precision


@law
def _way(u):
    """Return the way of a velocity: 1, -1, or 0."""
    return select(u > 0.0, 1.0, select(u < 0.0, -1.0, 0.0))


@law
def _open(entry, c_i, c_j, unit):
    # Rows and columns of held joints are those of the unit matrix.
    return select((c_i == 0.0) | (c_j == 0.0), unit, entry)


@law
def _if_sliding(c, x):
    return select(c == 0.0, 0.0, x)


@law
def _slid(c, p, low, high):
    return p + select(c > 0.0, low, high)


@composition
def _velocities(M, p, low, high, c):
    """Velocities of joints that slide as `c` says, and zero of those that are held."""
    n = len(p)
    A, x, ways = slots(M), slots(each(_slid, c, p, low, high)), slots(c)
    at = 0
    for i in range(n):
        for j in range(i, n):
            A[at] = _open(A[at], ways[i], ways[j], 1.0 if i == j else 0.0)
            at += 1
        x[i] = _if_sliding(ways[i], x[i])
    # A = L D L^T in place, row by row; `row` and `below` are where rows of the triangle begin.
    row = 0
    for i in range(n):
        per, below = 1.0 / A[row], row
        for j in range(i + 1, n):
            below += n - j + 1
            share = A[row + j - i] * per
            for k in range(j, n):
                A[below + k - j] = A[below + k - j] - share * A[row + k - i]
            x[j] = x[j] - share * x[i]
        row += n - i
    for back in range(n):
        i = n - 1 - back
        row -= n - i
        for j in range(i + 1, n):
            x[i] = x[i] - A[row + j - i] * x[j]
        x[i] = _if_sliding(ways[i], x[i] * (1.0 / A[row]))  # the reciprocal is there before the sum is
    return gather(p, x)


@law
def _missing(needed, p):
    return needed - p


@law
def _turned(c, w, J, low, high):
    # How a joint goes instead: as before, unless that is against what follows from it.
    between = ROUNDING * epsilon(J) * (high - low)
    slips = select(high + between < J, -1.0, select(low - between > J, 1.0, 0.0))
    return select(c == 0.0, slips, select((c * w < 0.0) & (low < high), 0.0, c))


@law
def _limited(J, low, high):
    return min(max(J, low), high)


@law
def _change(c, better):
    return abs(better - c)


@law
def _first(c, better, free):
    # Changed, if nothing was before it; and whether the next may still be.
    here = (free > 0.5) & ((c < better) | (c > better))
    return select(here, better, c), select(here, 0.0, free)


@composition
def _first_change(c, better):
    ways, others = slots(c), slots(better)
    free = 0.0 * ways[0] + 1.0
    for i in range(len(c)):
        ways[i], free = _first(ways[i], others[i], free)
    return gather(c, ways)


@composition
def brake_many(M, p, u, low, high):
    """Return velocities after friction, and its impulses, tuples; a held joint's velocity is exactly 0.

    Args: upper triangle of the mass matrix; tuples of momenta, of velocities before the step, and of least and greatest
    impulses.
    """
    c = each(_way, u)
    w = _velocities(M, p, low, high, c)
    J = each(_missing, times(M, w), p)
    better = each(_turned, c, w, J, low, high)
    turn = 0
    while anywhere(total(each(_change, c, better))) and turn < ROUNDS:
        c = _first_change(c, better) if turn >= BLOCKS else better
        w = _velocities(M, p, low, high, c)
        J = each(_missing, times(M, w), p)
        better = each(_turned, c, w, J, low, high)
        turn += 1
    return w, each(_limited, J, low, high)
