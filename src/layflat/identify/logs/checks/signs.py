"""Signals that are turned round, or late beside others: seen from what drives what.

The valve changes the pressure difference, which turns the joint. Each of both is a correlation that is clearly positive
where the signs are right, whatever the gains, loads and frictions: of the rise of pressure with voltage, pressure and
speed held, and of the turn in the next moment with the pressure difference.

A joint's torques balance at every moment. So the pressure difference is a function of angle, speed and acceleration at
the same time: stiffness and load, damping and friction, inertia. Where it is one of those at another time, by far
better than at the same, one of both came through a filter, or by another clock.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from layflat.arrays import Array
from layflat.identify.logs.checks.channels import CheckedLog, Issue, noise, smoothed

SMOOTH = 0.04  # time of averaging, s: two periods of a dither
SOON = 0.2  # how far ahead a turn is looked at, s: what a joint takes to follow its pressures
CLEAR = -0.25  # correlation below which a sign is wrong
LEAST = 30  # samples that a correlation needs


def sign_issues(log: CheckedLog) -> Iterator[Issue]:
    """Signs of angle, pressures, voltage and set-points of each joint."""
    for joint in log.joints or (None,):
        yield from _joint(joint, log)


def _joint(joint: str | None, log: CheckedLog) -> Iterator[Issue]:
    angle, voltage, demand = (log.of(signal, joint) for signal in ("angle", "voltage", "demand"))
    difference = log.difference(joint)
    turned = difference is not None and angle is not None and _turn(angle.values, difference, log.period) < CLEAR
    filled = None
    if voltage is not None and difference is not None:
        speed = np.gradient(angle.values, log.period) if angle is not None else None
        filled = _drive(voltage.values, difference, log.period, speed)
    pressures = " and ".join(
        c.name for s in ("measured_pressure", "pressure_a", "pressure_b") if (c := log.of(s, joint)) is not None
    )
    swap = "turn the differential pressure round with sign = -1, or swap hoses A and B"
    if filled is not None and filled < CLEAR and voltage is not None:
        if turned:
            text = "rise when the voltage falls, and the joint turns against them"
            yield Issue("error", pressures, text, swap)
            turned = False
        else:
            text = f"rises when {pressures} fall (correlation {filled:.2f})"
            right = "turn it round with sign = -1 and offset = twice the valve's centre, or swap hoses A and B"
            yield Issue("error", voltage.name, text, right)
    if turned and angle is not None:
        known = "turn it round with sign = -1" if filled is not None else f"turn it round with sign = -1, or {swap}"
        yield Issue("error", angle.name, "turns against the pressure difference", known)
    if angle is not None and demand is not None:
        followed = _correlation(demand.values, angle.values)
        if followed < 2.0 * CLEAR:
            text = f"goes against {demand.name} (correlation {followed:.2f})"
            yield Issue("error", angle.name, text, "turn one of them round with sign = -1")
    for hose in ("a", "b"):
        pressure, setpoint = log.of(f"pressure_{hose}", joint), log.of(f"setpoint_{hose}", joint)
        if pressure is not None and setpoint is not None:
            drive = _drive(setpoint.values, pressure.values, log.period, None)
            if drive is not None and drive < CLEAR:
                text = f"falls when {setpoint.name} rises (correlation {drive:.2f})"
                yield Issue("error", pressure.name, text, "swap hoses A and B of the pressures or of the set-points")


def _turn(angle: Array, difference: Array, period: float) -> float:
    """Correlation of the pressure difference with how far the joint turns in the moment that follows; 0: not known."""
    window, ahead = max(1, round(SMOOTH / period)), max(1, round(SOON / period))
    x, y = smoothed(difference, window), smoothed(angle, window)
    if x.size <= ahead + LEAST:
        return 0.0
    turn = y[ahead:] - y[:-ahead]
    known = angle[np.isfinite(angle)]
    if not np.isfinite(turn).any() or np.nanmax(turn) - np.nanmin(turn) < 6.0 * noise(known):
        return 0.0
    return _correlation(x[:-ahead], turn)


def _drive(drive: Array, level: Array, period: float, speed: Array | None) -> float | None:
    """Correlation of a level's rise with what drives it, less what both owe to the level, and to a speed."""
    window = max(1, round(SMOOTH / period))
    smooth = [smoothed(signal, window) for signal in (drive, level, *([] if speed is None else [speed]))]
    rise = np.diff(smooth[1])
    drive, *others = [signal[:-1] for signal in smooth]
    rows = np.isfinite(rise) & np.isfinite(drive) & np.all([np.isfinite(other) for other in others], axis=0)
    if rows.sum() < LEAST or np.ptp(drive[rows]) == 0.0:
        return None
    taken = [other[rows] for other in others]
    return _correlation(_without(drive[rows], taken), _without(rise[rows], taken))


def _without(values: Array, others: list[Array]) -> Array:
    """Return the residual of a signal after its best linear fit by others."""
    columns = [(other - other.mean()) / (np.std(other) or 1.0) for other in others]
    basis = np.stack([*columns, np.ones(values.size)], axis=1)
    weights, *_ = np.linalg.lstsq(basis, values, rcond=None)
    left: Array = values - basis @ weights
    return left


def _correlation(x: Array, y: Array) -> float:
    """Return the correlation over samples that both have; 0 for too few samples or a constant signal."""
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    if x.size < LEAST or np.std(x) <= 1e-12 * np.abs(x).max() or np.std(y) <= 1e-12 * np.abs(y).max():
        return 0.0
    return float(np.corrcoef(x, y)[0, 1])


WINDOW = 0.12  # time over which signals are smoothed alike, s
MAX_LAG = 0.2  # s; a best fit there is no lag
STEP = 0.005  # s between samples that are enough for it
MAX_ROWS = 20_000  # samples that are fitted
MIN_ROWS = 60
MOVING = 0.1  # share of a fast speed from which a joint moves
SLIDING = 0.05  # the same about which friction turns round
EXPLAINED = 0.93  # share of the variance that has to be explained
CLEAR_LAG = ((0.06, 2.0), (0.03, 5.0))  # lags, s, with how many times smaller the residual has to be than without


def lag_issues(log: CheckedLog) -> Iterator[Issue]:
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
    clear = any(abs(lag) >= max(least, 1.5 * period) and ratio >= times for least, times in CLEAR_LAG)
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
