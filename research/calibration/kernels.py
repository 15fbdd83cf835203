"""Compiled kernel of the calibration, in a file of its own: machine code depends on all that a file imports."""

import numpy as np

from layflat.jit import kernel


@kernel
def evaluate_errors(error, band, last, lost):  # type: ignore[no-untyped-def]
    """Return records until errors (runs, records) stay inside the band, and range and rms of the last ones, (runs, 3).

    `last` records count for the range, twice as many for the rms; nan counts as `lost`.
    """
    found = np.empty((len(error), 3))
    for i in range(len(error)):
        outside, high, low, squares = 0, -np.inf, np.inf, 0.0
        n = error.shape[1]
        for k in range(n):
            one = error[i, k]
            one = lost if np.isnan(one) else one
            outside = outside if abs(one) <= band else k + 1
            if k >= n - last:
                high, low = max(high, one), min(low, one)
            if k >= n - 2 * last:
                squares += one * one
        found[i, 0], found[i, 1], found[i, 2] = outside, high - low, np.sqrt(squares / min(n, 2 * last))
    return found
