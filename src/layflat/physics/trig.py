"""Sine and cosine as polynomials: the same bits on every machine, and usable in vector lanes."""

from layflat.jit import law


@law
def sincos(x):
    """sin(x) and cos(x) to 1e-12 for |x| <= pi (rad), by Taylor series at x/4 and two doublings."""
    y = 0.25 * x
    z = y * y
    s = y * (
        1.0 + z * (-1 / 6 + z * (1 / 120 + z * (-1 / 5040 + z * (1 / 362880 + z * (-1 / 39916800 + z / 6227020800)))))
    )
    # 1 - cos is kept instead of cos, which would lose its digits near zero.
    v = z * (
        0.5
        + z
        * (-1 / 24 + z * (1 / 720 + z * (-1 / 40320 + z * (1 / 3628800 + z * (-1 / 479001600 + z / 87178291200)))))
    )
    s, v = 2.0 * s * (1.0 - v), 2.0 * s * s
    return 2.0 * s * (1.0 - v), 1.0 - 2.0 * s * s
