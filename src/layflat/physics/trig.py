"""Sine and cosine as polynomials: the same bits on every machine, and usable in vector lanes."""

from math import pi

from layflat.jit import law
from layflat.lanes import epsilon

S_3, S_5, S_7, S_9, S_11, S_13 = -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800, 1 / 6227020800
C_4, C_6, C_8, C_10, C_12, C_14 = -1 / 24, 1 / 720, -1 / 40320, 1 / 3628800, -1 / 479001600, 1 / 87178291200


TURN = 2.0 * pi
NEAREST = 1.5  # over the last place of 1: numbers beyond that are whole; added and taken off again, it rounds


@law
def within_half_a_turn(x):
    """Return the same angle within +-pi, rad: not another bit where it is."""
    nearest = NEAREST / epsilon(x)
    return x - TURN * ((x / TURN + nearest) - nearest)


@law
def sincos(x):
    """sin(x) and cos(x) to 1e-12 for |x| <= pi (rad), by Taylor series at x/4 and two doublings."""
    y = 0.25 * x
    z = y * y
    w = z * z
    # In pairs (Estrin's scheme): half as deep as Horner's. 1 - cos is kept instead of cos, which would lose its digits
    # near zero.
    s = y * ((1.0 + z * S_3 + w * (S_5 + z * S_7)) + w * w * (S_9 + z * S_11 + w * S_13))
    v = z * ((0.5 + z * C_4 + w * (C_6 + z * C_8)) + w * w * (C_10 + z * C_12 + w * C_14))
    s, v = 2.0 * s * (1.0 - v), 2.0 * s * s
    return 2.0 * s * (1.0 - v), 1.0 - 2.0 * s * s
