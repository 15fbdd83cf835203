"""Sine and cosine as polynomials: the same bits on every computer, and usable in SIMD lanes."""

from math import pi

from layflat.jit import law
from layflat.lanes import epsilon

__all__ = ["sincos"]

S_3, S_5, S_7, S_9, S_11, S_13 = -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800, 1 / 6227020800
C_4, C_6, C_8, C_10, C_12, C_14 = -1 / 24, 1 / 720, -1 / 40320, 1 / 3628800, -1 / 479001600, 1 / 87178291200


FULL_TURN = 2.0 * pi
ROUNDING_SCALE = (
    1.5  # over epsilon: so large a number is whole; adding and subtracting it rounds to the nearest integer
)


@law
def wrap_angle(x):
    """Return an angle wrapped into +-pi, rad; one inside keeps its bits."""
    nearest = ROUNDING_SCALE / epsilon(x)
    return x - FULL_TURN * ((x / FULL_TURN + nearest) - nearest)


@law
def sincos(x):
    """Return sin(x) and cos(x) to 1e-12 for |x| <= pi (rad), by Taylor series at x/4 and two doublings."""
    y = 0.25 * x
    z = y * y
    w = z * z
    # In pairs (Estrin's scheme): half as deep as Horner's. 1 - cos is kept instead of cos, which would lose its digits
    # near zero.
    s = y * ((1.0 + z * S_3 + w * (S_5 + z * S_7)) + w * w * (S_9 + z * S_11 + w * S_13))
    v = z * ((0.5 + z * C_4 + w * (C_6 + z * C_8)) + w * w * (C_10 + z * C_12 + w * C_14))
    s, v = 2.0 * s * (1.0 - v), 2.0 * s * s
    return 2.0 * s * (1.0 - v), 1.0 - 2.0 * s * s
