"""Means of the positive and of the negative part of a quantity that changes linearly during a step.

| symbol | meaning |
|---|---|
| a, b | the quantity at the beginning and at the end of the step |
"""

from layflat.jit import law

QUOTIENT_FLOOR = 1e-30  # keeps a quotient of two zeros at zero


@law
def mean_above_zero(a, b):
    """Return the mean of max(y, 0) while y goes linearly from a to b: (a+ + b+)^2 / (2 (|a| + |b|)), a+ = max(a, 0).

    It is exact where y passes zero, too.
    """
    above = max(a, 0.0) + max(b, 0.0)
    return above * above / (2.0 * (abs(a) + abs(b)) + QUOTIENT_FLOOR)


@law
def mean_below_zero(a, b):
    """Return the mean of max(-y, 0) while y goes linearly from a to b, exactly."""
    below = min(a, 0.0) + min(b, 0.0)
    return below * below / (2.0 * (abs(a) + abs(b)) + QUOTIENT_FLOOR)
