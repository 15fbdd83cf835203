"""Vectors and symmetric matrices of any size as tuples; a symmetric matrix is its upper triangle, row by row.

Slots take the place of lists, so that all of it is compiled without a heap, for numbers and for lanes.
"""

from layflat.jit import composition, law
from layflat.lanes import each, gather, slots, total

IMMOVABLE_INERTIA = 1e12  # kg m2, far above any inertia of an arm: a coordinate that has it does not move


@law
def triangle_index(i, j, n):
    """Return the index of row i and column j of an n x n symmetric matrix in its upper triangle."""
    first, last = min(i, j), max(i, j)
    return first * n - first * (first - 1) // 2 + last - first


@law
def _product(a, b):
    return a * b


@composition
def dot(x, y):
    """Return the scalar product of two tuples."""
    return total(each(_product, x, y))


@law
def _max_of_two(a, b):
    return max(a, b)


@composition
def max_item(values):
    """Return the maximum of a tuple's values."""
    items = slots(values)
    maximum = items[0]
    for i in range(1, len(values)):
        maximum = _max_of_two(maximum, items[i])
    return maximum


@law
def _magnitude(x):
    return abs(x)


@composition
def max_magnitude(values):
    """Return the maximum of a tuple's absolute values."""
    return max_item(each(_magnitude, values))


@law
def negate(x):
    """Return -x, of a number or of lanes."""
    return -x


@composition
def min_item(values):
    """Return the minimum of a tuple's values."""
    return -max_item(each(negate, values))


@composition
def diagonal(upper, like):
    """Return the diagonal of a symmetric matrix, a tuple with as many items as `like`."""
    M, items, n = slots(upper), slots(like), len(like)
    for i in range(n):
        items[i] = M[triangle_index(i, i, n)]
    return gather(like, items)


@composition
def multiply_symmetric(upper, vector):
    """Return the product of a symmetric matrix and a vector."""
    M, x, n = slots(upper), slots(vector), len(vector)
    y, at = slots(vector, 0.0 * x[0]), 0
    for i in range(n):
        y[i] = y[i] + M[at] * x[i]
        for j in range(i + 1, n):
            at += 1
            y[i], y[j] = y[i] + M[at] * x[j], y[j] + M[at] * x[i]
        at += 1
    return gather(vector, y)


@composition
def invert_symmetric(upper, fixed, like):
    """Return the inverse of a positive definite matrix as a tuple of n^2 items, row by row.

    Args: `upper`: the matrix; `fixed`: n items, 1.0 for a coordinate that does not move, whose row and column of the
    inverse are zero, else 0.0; `like`: a tuple of n^2 items.
    """
    M, held, n = slots(upper), slots(fixed), len(fixed)
    zero = 0.0 * held[0]
    A = slots(like, zero)
    for i in range(n):
        for j in range(n):
            A[i * n + j] = M[triangle_index(i, j, n)] + zero
        A[i * n + i] = A[i * n + i] + IMMOVABLE_INERTIA * held[i]
    # In place, by Gauss and Jordan: a positive definite matrix needs no pivots.
    for k in range(n):
        per = 1.0 / A[k * n + k]
        A[k * n + k] = 1.0 + zero
        for j in range(n):
            A[k * n + j] = A[k * n + j] * per
        for i in range(n):
            if i != k:
                by = A[i * n + k]
                A[i * n + k] = zero
                for j in range(n):
                    A[i * n + j] = A[i * n + j] - by * A[k * n + j]
    return gather(like, A)
