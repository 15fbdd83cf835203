"""Signals with a wrong sign or a time lag, from the correlations between cause and effect.

The valve changes the pressure difference, which rotates the joint. With right signs two correlations are clearly
positive, for all gains, loads and frictions: of the rate of pressure with the voltage, for constant pressure and speed,
and of the following rotation with the pressure difference.

A joint's torques balance at every instant. So the pressure difference is a function of angle, speed and acceleration at
the same time: stiffness and load, damping and friction, inertia. Where it fits those at another time far better, one of
both signals is filtered, or has another clock.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from layflat.arrays import Array
from layflat.identify.logs.checks.channels import CheckedLog, Issue, moving_average, noise_deviation

AVERAGING_TIME = 0.04  # of the moving average, s: two periods of a dither
LOOKAHEAD_TIME = 0.2  # over which a rotation is measured, s: the time a joint takes to follow its pressures
WRONG_SIGN_CORRELATION = -0.25  # correlation below which a sign is wrong
MIN_CORRELATION_SAMPLES = 30  # of a correlation


def sign_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield an error for each wrong sign of a joint's angle, pressures, voltage, demand or set-points."""
    for joint in log.joints or (None,):
        yield from _joint_sign_issues(joint, log)


def _joint_sign_issues(joint: str | None, log: CheckedLog) -> Iterator[Issue]:
    """Yield an error where angle, pressures, voltage, demand or set-points of a joint contradict each other in sign."""
    angle, voltage, demand = (log.find_channel(signal, joint) for signal in ("angle", "voltage", "demand"))
    difference = log.difference(joint)
    against = (
        difference is not None
        and angle is not None
        and _rotation_correlation(angle.values, difference, log.period) < WRONG_SIGN_CORRELATION
    )
    drive_sign = None
    if voltage is not None and difference is not None:
        speed = np.gradient(angle.values, log.period) if angle is not None else None
        drive_sign = _drive_correlation(voltage.values, difference, log.period, speed)
    pressures = " and ".join(
        c.name
        for s in ("measured_pressure", "pressure_a", "pressure_b")
        if (c := log.find_channel(s, joint)) is not None
    )
    swap = "turn the differential pressure round with sign = -1, or swap hoses A and B"
    if drive_sign is not None and drive_sign < WRONG_SIGN_CORRELATION and voltage is not None:
        if against:
            text = "rise when the voltage falls, and the joint turns against them"
            yield Issue("error", pressures, text, swap)
            against = False
        else:
            text = f"rises when {pressures} fall (correlation {drive_sign:.2f})"
            right = "turn it round with sign = -1 and offset = twice the valve's centre, or swap hoses A and B"
            yield Issue("error", voltage.name, text, right)
    if against and angle is not None:
        advice = (
            "turn it round with sign = -1" if drive_sign is not None else f"turn it round with sign = -1, or {swap}"
        )
        yield Issue("error", angle.name, "turns against the pressure difference", advice)
    if angle is not None and demand is not None:
        tracking = _correlation(demand.values, angle.values)
        if tracking < 2.0 * WRONG_SIGN_CORRELATION:
            text = f"goes against {demand.name} (correlation {tracking:.2f})"
            yield Issue("error", angle.name, text, "turn one of them round with sign = -1")
    for hose in ("a", "b"):
        pressure, setpoint = log.find_channel(f"pressure_{hose}", joint), log.find_channel(f"setpoint_{hose}", joint)
        if pressure is not None and setpoint is not None:
            drive = _drive_correlation(setpoint.values, pressure.values, log.period, None)
            if drive is not None and drive < WRONG_SIGN_CORRELATION:
                text = f"falls when {setpoint.name} rises (correlation {drive:.2f})"
                yield Issue("error", pressure.name, text, "swap hoses A and B of the pressures or of the set-points")


def _rotation_correlation(angle: Array, difference: Array, period: float) -> float:
    """Return the correlation of the pressure difference with the rotation in the next `LOOKAHEAD_TIME`; 0: unknown."""
    window, ahead = max(1, round(AVERAGING_TIME / period)), max(1, round(LOOKAHEAD_TIME / period))
    x, y = moving_average(difference, window), moving_average(angle, window)
    if x.size <= ahead + MIN_CORRELATION_SAMPLES:
        return 0.0
    rotation = y[ahead:] - y[:-ahead]
    samples = angle[np.isfinite(angle)]
    if not np.isfinite(rotation).any() or np.nanmax(rotation) - np.nanmin(rotation) < 6.0 * noise_deviation(samples):
        return 0.0
    return _correlation(x[:-ahead], rotation)


def _drive_correlation(drive: Array, level: Array, period: float, speed: Array | None) -> float | None:
    """Return the partial correlation of a level's rise with its drive, for constant level and speed; None: unknown.

    Args:
        drive: voltage or set-point, (samples,).
        level: pressure, Pa, (samples,).
        period: between samples, s.
        speed: speed of the joint, rad/s, (samples,), or None.
    """
    window = max(1, round(AVERAGING_TIME / period))
    smooth = [moving_average(signal, window) for signal in (drive, level, *([] if speed is None else [speed]))]
    rise = np.diff(smooth[1])
    drive, *others = [signal[:-1] for signal in smooth]
    rows = np.isfinite(rise) & np.isfinite(drive) & np.all([np.isfinite(other) for other in others], axis=0)
    if rows.sum() < MIN_CORRELATION_SAMPLES or np.ptp(drive[rows]) == 0.0:
        return None
    held = [other[rows] for other in others]
    return _correlation(_residual(drive[rows], held), _residual(rise[rows], held))


def _residual(values: Array, others: list[Array]) -> Array:
    """Return the residual of a signal after its best linear fit by others."""
    columns = [(other - other.mean()) / (np.std(other) or 1.0) for other in others]
    basis = np.stack([*columns, np.ones(values.size)], axis=1)
    weights, *_ = np.linalg.lstsq(basis, values, rcond=None)
    residual: Array = values - basis @ weights
    return residual


def _correlation(x: Array, y: Array) -> float:
    """Return the correlation over samples that both have; 0 for too few samples or a constant signal."""
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    if x.size < MIN_CORRELATION_SAMPLES or np.std(x) <= 1e-12 * np.abs(x).max() or np.std(y) <= 1e-12 * np.abs(y).max():
        return 0.0
    return float(np.corrcoef(x, y)[0, 1])


LAG_WINDOW = 0.12  # over which both signals are smoothed, s
MAX_LAG = 0.2  # s; a best fit at this limit is no lag
LAG_STEP = 0.005  # s between the samples that are used
MAX_LAG_SAMPLES = 20_000  # used in a fit
MIN_LAG_SAMPLES = 60
MOVING_SPEED_RATIO = 0.1  # of a moving joint, over a fast speed
REVERSAL_SPEED_RATIO = 0.05  # width of the reversal of friction, over a fast speed
MIN_EXPLAINED_VARIANCE = 0.93  # fraction of the variance that the best fit has to explain
LAG_CRITERIA = ((0.06, 2.0), (0.03, 5.0))  # least lag, s, and least ratio of the residuals without and with it


def lag_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield a warning for each joint whose angle lags or leads its pressures significantly: see `estimate_lag`."""
    for joint in log.joints or (None,):
        angle, difference = log.find_channel("angle", joint), log.difference(joint)
        if angle is None or difference is None or log.period <= 0.0:
            continue
        lag = estimate_lag(angle.values, difference, log.period)
        if lag is None:
            continue
        side = "after" if lag > 0.0 else "before"
        text = f"comes about {1e3 * abs(lag):.0f} ms {side} the pressures that turn the joint"
        right = (
            "one of both is filtered, or has another clock: map what is not, or shift its time; a fit would bend to it"
        )
        yield Issue("warning", angle.name, text, right)


def estimate_lag(angle: Array, difference: Array, period: float) -> float | None:
    """Return the lag of an angle behind the pressure difference; None where no lag is significant.

    Args:
        angle: rad, (samples,), NaN where there is none.
        difference: difference of the pressures, Pa, (samples,).
        period: between samples, s.

    Returns:
        Lag, s: positive where the angle is late.
    """
    stride = max(1, round(LAG_STEP / period))
    reach = int(MAX_LAG / (period * stride))
    window = max(5, round(LAG_WINDOW / period) | 1)
    if reach < 2 or angle.size < max(2 * window, MIN_LAG_SAMPLES):
        return None
    pressure = savgol_filter(difference, window, 3, mode="nearest")[::stride]
    basis = _torque_terms(angle, window, period)[::stride]
    fast = np.abs(basis[:, 4]) > MOVING_SPEED_RATIO  # column 4 is the speed over a fast one
    rows = np.arange(reach, len(pressure) - reach)
    rows = rows[:: max(1, len(rows) // MAX_LAG_SAMPLES)]
    fits = np.array(
        [_unexplained_variance(pressure, basis, rows[fast[rows + lag]], lag) for lag in range(-reach, reach + 1)]
    )
    if np.isnan(fits).any():
        return None
    best = int(np.argmin(fits))
    if best in {0, len(fits) - 1} or not fits[best] < 1.0 - MIN_EXPLAINED_VARIANCE:
        return None
    lag = (best - reach) * period * stride
    ratio = fits[reach] / max(fits[best], 1e-12)
    significant = any(
        abs(lag) >= max(min_lag, 1.5 * period) and ratio >= min_ratio for min_lag, min_ratio in LAG_CRITERIA
    )
    return lag if significant else None


def _torque_terms(angle: Array, window: int, period: float) -> Array:
    """Return scaled terms of a joint's torque, (samples, 7): powers 0 to 3 of angle, speed, its sign, acceleration."""
    smooth, speed, bend = (savgol_filter(angle, window, 3, deriv=n, delta=period, mode="nearest") for n in range(3))
    finite = np.isfinite(smooth) & np.isfinite(bend)
    x = smooth / (float(np.std(smooth[finite])) or 1.0) if finite.any() else smooth
    v = speed / (float(np.percentile(np.abs(speed[finite]), 95.0)) or 1.0) if finite.any() else speed
    a = bend / (float(np.std(bend[finite])) or 1.0) if finite.any() else bend
    return np.stack([np.ones_like(x), x, x**2, x**3, v, np.tanh(v / REVERSAL_SPEED_RATIO), a], axis=1)


def _unexplained_variance(pressure: Array, basis: Array, rows: NDArray[np.intp], lag: int) -> float:
    """Return the fraction of the pressure's variance that the terms `lag` samples later leave; NaN for few samples."""
    x, y = basis[rows + lag], pressure[rows]
    finite = np.isfinite(x).all(axis=1) & np.isfinite(y)
    x, y = x[finite], y[finite]
    if len(y) < MIN_LAG_SAMPLES or np.ptp(y) == 0.0:
        return np.nan
    weights, *_ = np.linalg.lstsq(x, y, rcond=None)
    return float(np.var(y - x @ weights) / np.var(y))
