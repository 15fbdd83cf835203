"""Signals that come late beside others: an angle and the pressures that turn the joint.

A joint's torques balance at every moment. So the pressure difference is a function of angle, speed and acceleration at
the same time: stiffness and load, damping and friction, inertia. Where it is one of those at another time, by far
better than at the same, one of both came through a filter, or by another clock.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from layflat.arrays import Array
from layflat.identify.logs.checks.channels import CheckedLog, Issue

WINDOW = 0.12  # time over which signals are smoothed alike, s
MAX_LAG = 0.2  # s; a best fit there is no lag
STEP = 0.005  # s between samples that are enough for it
MAX_ROWS = 20_000  # samples that are fitted
MIN_ROWS = 60
MOVING = 0.1  # share of a fast speed from which a joint moves
SLIDING = 0.05  # the same about which friction turns round
EXPLAINED = 0.93  # share of the variance that has to be explained
CLEAR = ((0.06, 2.0), (0.03, 5.0))  # lags, s, with how many times smaller the residual has to be than without


def issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield joints whose angle and pressures are not of one time."""
    for joint in log.joints or (None,):
        angle, difference = log.of("angle", joint), log.difference(joint)
        if angle is None or difference is None or log.period <= 0.0:
            continue
        lag = lag_of(angle.values, difference, log.period)
        if lag is None:
            continue
        side = "after" if lag > 0.0 else "before"
        text = f"comes about {1e3 * abs(lag):.0f} ms {side} the pressures that turn the joint"
        right = (
            "one of both is filtered, or has another clock: map what is not, or shift its time; a fit would bend to it"
        )
        yield Issue("warning", angle.name, text, right)


def lag_of(angle: Array, difference: Array, period: float) -> float | None:
    """Return by how much an angle comes after the pressure difference; None where none is clear.

    Args:
        angle: rad, (samples,), NaN where there is none.
        difference: of the pressures, Pa, (samples,).
        period: between samples, s.

    Returns:
        Lag, s: positive where the angle is late.
    """
    every = max(1, round(STEP / period))
    reach = int(MAX_LAG / (period * every))
    window = max(5, round(WINDOW / period) | 1)
    if reach < 2 or angle.size < max(2 * window, MIN_ROWS):
        return None
    pressure = savgol_filter(difference, window, 3, mode="nearest")[::every]
    basis = _basis(angle, window, period)[::every]
    fast = np.abs(basis[:, 4]) > MOVING  # column 4 is the speed over a fast one
    rows = np.arange(reach, len(pressure) - reach)
    rows = rows[:: max(1, len(rows) // MAX_ROWS)]
    fits = np.array([_unexplained(pressure, basis, rows[fast[rows + lag]], lag) for lag in range(-reach, reach + 1)])
    if np.isnan(fits).any():
        return None
    best = int(np.argmin(fits))
    if best in {0, len(fits) - 1} or not fits[best] < 1.0 - EXPLAINED:
        return None
    lag = (best - reach) * period * every
    ratio = fits[reach] / max(fits[best], 1e-12)
    clear = any(abs(lag) >= max(least, 1.5 * period) and ratio >= times for least, times in CLEAR)
    return lag if clear else None


def _basis(angle: Array, window: int, period: float) -> Array:
    """Return what torques are functions of, (samples, terms): angle, speed, sense of motion, acceleration."""
    smooth, speed, bend = (savgol_filter(angle, window, 3, deriv=n, delta=period, mode="nearest") for n in range(3))
    known = np.isfinite(smooth) & np.isfinite(bend)
    x = smooth / (float(np.std(smooth[known])) or 1.0) if known.any() else smooth
    v = speed / (float(np.percentile(np.abs(speed[known]), 95.0)) or 1.0) if known.any() else speed
    a = bend / (float(np.std(bend[known])) or 1.0) if known.any() else bend
    return np.stack([np.ones_like(x), x, x**2, x**3, v, np.tanh(v / SLIDING), a], axis=1)


def _unexplained(pressure: Array, basis: Array, rows: NDArray[np.intp], lag: int) -> float:
    """Return the share of the pressure's variance that an angle some samples later does not explain; NaN of few."""
    x, y = basis[rows + lag], pressure[rows]
    known = np.isfinite(x).all(axis=1) & np.isfinite(y)
    x, y = x[known], y[known]
    if len(y) < MIN_ROWS or np.ptp(y) == 0.0:
        return np.nan
    weights, *_ = np.linalg.lstsq(x, y, rcond=None)
    return float(np.var(y - x @ weights) / np.var(y))
