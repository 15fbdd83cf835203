"""Dry friction of any number of coupled joints as impulses over one step: a held joint has velocity 0 exactly.

| symbol | meaning | unit |
|---|---|---|
| M | mass matrix | kg m2 |
| p | momentum (M v)_i after the step if there were no friction | kg m2 rad/s |
| low, high | minimum and maximum impulse of friction in this step | N m s |
| J | impulse of friction | N m s |
| w | velocity after the step | rad/s |
| c | assumed direction of a joint: 1 or -1 where it slides, 0 where it is held | 1 |

The problem of `brake_two` (turning.py) for more than two joints: M w = p + J, where a joint is held (w = 0, low <= J <=
high) or slides (forward with J = low, back with J = high): a linear complementarity problem. For a given c it is
linear; a solution that contradicts c revises it: a joint that would slide the other way is held, one whose holding
impulse exceeds its limits slides. Started from the directions before the step, one round is mostly enough. All
contradictions are revised at once (block pivoting); after `MAX_BLOCK_ROUNDS` rounds only the first one, which
terminates since M is positive definite (judice1994).
"""

from layflat.jit import composition, law
from layflat.lanes import anywhere, each, epsilon, gather, select, slots, total
from layflat.physics.algebra import multiply_symmetric

MAX_BLOCK_ROUNDS, MAX_PIVOT_ROUNDS = 6, 60  # rounds that revise all contradictions, and upper limit of rounds
BOUND_ROUNDING = 0.5e-12 * 2.0**52  # tolerance of the limits: units in the last place of high - low


@law
def _sign(u):
    """Return the sign of a velocity: 1, -1, or 0."""
    return select(u > 0.0, 1.0, select(u < 0.0, -1.0, 0.0))


@law
def _unit_if_held(entry, c_i, c_j, unit):
    """Return an entry of the matrix: rows and columns of held joints are those of the unit matrix."""
    return select((c_i == 0.0) | (c_j == 0.0), unit, entry)


@law
def _zero_if_held(c, x):
    return select(c == 0.0, 0.0, x)


@law
def _sliding_momentum(c, p, low, high):
    return p + select(c > 0.0, low, high)


@composition
def _velocities(M, p, low, high, c):
    """Return the velocities of joints that slide in the directions c, and zero of those that are held."""
    n = len(p)
    A, x, directions = slots(M), slots(each(_sliding_momentum, c, p, low, high)), slots(c)
    at = 0
    for i in range(n):
        for j in range(i, n):
            A[at] = _unit_if_held(A[at], directions[i], directions[j], 1.0 if i == j else 0.0)
            at += 1
        x[i] = _zero_if_held(directions[i], x[i])
    # A = L D L^T in place, row by row; `row` and `below` are where rows of the triangle begin.
    row = 0
    for i in range(n):
        per, below = 1.0 / A[row], row
        for j in range(i + 1, n):
            below += n - j + 1
            factor = A[row + j - i] * per
            for k in range(j, n):
                A[below + k - j] = A[below + k - j] - factor * A[row + k - i]
            x[j] = x[j] - factor * x[i]
        row += n - i
    for back in range(n):
        i = n - 1 - back
        row -= n - i
        for j in range(i + 1, n):
            x[i] = x[i] - A[row + j - i] * x[j]
        x[i] = _zero_if_held(directions[i], x[i] * (1.0 / A[row]))  # the reciprocal is ready before the sum is
    return gather(p, x)


@law
def _required_impulse(momentum, p):
    return momentum - p


@law
def _revise_direction(c, w, J, low, high):
    """Return the direction of a joint for the next round: c, unless the solution (w, J) contradicts it."""
    between = BOUND_ROUNDING * epsilon(J) * (high - low)
    slips = select(high + between < J, -1.0, select(low - between > J, 1.0, 0.0))
    return select(c == 0.0, slips, select((c * w < 0.0) & (low < high), 0.0, c))


@law
def _clip_impulse(J, low, high):
    return min(max(J, low), high)


@law
def _direction_change(c, better):
    return abs(better - c)


@law
def _take_first(c, better, free):
    """Return a direction, revised if no joint before it was, and whether the next one may still be revised."""
    here = (free > 0.5) & ((c < better) | (c > better))
    return select(here, better, c), select(here, 0.0, free)


@composition
def _first_change(c, better):
    """Return the directions c with the first of the revised ones (`better`) that differs; later joints keep theirs."""
    directions, revised = slots(c), slots(better)
    free = 0.0 * directions[0] + 1.0
    for i in range(len(c)):
        directions[i], free = _take_first(directions[i], revised[i], free)
    return gather(c, directions)


@composition
def brake_many(M, p, u, low, high):
    """Return velocities after friction, and its impulses, tuples; a held joint's velocity is exactly 0.

    Args: upper triangle of the mass matrix; tuples of momenta, of velocities before the step, and of minimum and
    maximum impulses.
    """
    c = each(_sign, u)
    w = _velocities(M, p, low, high, c)
    J = each(_required_impulse, multiply_symmetric(M, w), p)
    better = each(_revise_direction, c, w, J, low, high)
    rounds = 0
    while anywhere(total(each(_direction_change, c, better))) and rounds < MAX_PIVOT_ROUNDS:
        c = _first_change(c, better) if rounds >= MAX_BLOCK_ROUNDS else better
        w = _velocities(M, p, low, high, c)
        J = each(_required_impulse, multiply_symmetric(M, w), p)
        better = each(_revise_direction, c, w, J, low, high)
        rounds += 1
    return w, each(_clip_impulse, J, low, high)
