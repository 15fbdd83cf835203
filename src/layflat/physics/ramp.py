"""A quantity that changes evenly during a step, of which only the part above zero counts.

| symbol | meaning |
|---|---|
| a, b | the quantity at the beginning and at the end of the step |
"""

from layflat.jit import law

TINY = 1e-30  # keeps a quotient of two zeros at zero


@law
def mean_above_zero(a, b):
    """Mean of max(y, 0) while y goes evenly from a to b, exactly: (a+ + b+)^2 / (2 (|a| + |b|)), a+ = max(a, 0).

    A step in which y passes zero so costs no accuracy.
    """
    above = max(a, 0.0) + max(b, 0.0)
    return above * above / (2.0 * (abs(a) + abs(b)) + TINY)


@law
def mean_below_zero(a, b):
    """Mean of max(-y, 0) while y goes evenly from a to b, exactly."""
    below = min(a, 0.0) + min(b, 0.0)
    return below * below / (2.0 * (abs(a) + abs(b)) + TINY)
