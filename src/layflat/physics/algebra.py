"""Vectors and symmetric matrices of any size as tuples, a matrix as its upper triangle, row by row.

Slots take the place of lists, so that all of it is compiled without a heap, for numbers and for lanes.
"""

from layflat.jit import composition, law
from layflat.lanes import each, gather, slots, total

GREAT = 1e12  # beside any inertia, kg m2: what has so much does not move


@law
def place(i, j, n):
    """Where the item of a row i and a column j of an upper triangle stands."""
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
def _greater(a, b):
    return max(a, b)


@composition
def greatest(values):
    """Return the greatest of a tuple's values."""
    items = slots(values)
    found = items[0]
    for i in range(1, len(values)):
        found = _greater(found, items[i])
    return found


@law
def _size(x):
    return abs(x)


@composition
def largest(values):
    """Return the greatest of a tuple's absolute values."""
    return greatest(each(_size, values))


@law
def minus(x):
    """Return -x, of lanes too where a law is called with them."""
    return -x


@composition
def least(values):
    """Return the least of a tuple's values."""
    return -greatest(each(minus, values))


@composition
def diagonal(upper, like):
    """Return the diagonal of a symmetric matrix, a tuple with as many items as `like`."""
    M, found, n = slots(upper), slots(like), len(like)
    for i in range(n):
        found[i] = M[place(i, i, n)]
    return gather(like, found)


@composition
def times(upper, vector):
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
def inverse(upper, fixed, like):
    """Return the inverse of a positive definite matrix, row by row, as many items as `like`; zero in fixed rows.

    Args: `fixed`: 1.0 for rows that are, else 0.0.
    """
    M, held, n = slots(upper), slots(fixed), len(fixed)
    zero = 0.0 * held[0]
    A = slots(like, zero)
    for i in range(n):
        for j in range(n):
            A[i * n + j] = M[place(i, j, n)] + zero
        A[i * n + i] = A[i * n + i] + GREAT * held[i]
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
