"""Signals that are turned round: seen from what drives what.

The valve changes the pressure difference, which turns the joint. Each of both is a correlation that is clearly positive
where the signs are right, whatever the gains, loads and frictions: of the rise of pressure with voltage, pressure and
speed held, and of the turn in the next moment with the pressure difference.
"""

from collections.abc import Iterator

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.checks.channels import CheckedLog, Issue, noise, smoothed

SMOOTH = 0.04  # time of averaging, s: two periods of a dither
SOON = 0.2  # how far ahead a turn is looked at, s: what a joint takes to follow its pressures
CLEAR = -0.25  # correlation below which a sign is wrong
LEAST = 30  # samples that a correlation needs


def issues(log: CheckedLog) -> Iterator[Issue]:
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
