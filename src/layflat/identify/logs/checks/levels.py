"""Pressures of one joint that count from different levels, one from ambient and one from vacuum; and where ambient is.

What belongs together tells it: a difference that was measured, a set-point that is followed, or the other hose.
"""

from collections.abc import Iterator

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.checks.channels import Channel, CheckedLog, Issue

HIGHEST_AIR, LOWEST_AIR = 1.1e5, 4.5e4  # pressures of the air from below the sea's level to 6000 m, Pa
OTHER_AIR = 5e3  # difference from the machine's ambient pressure that no weather makes at one place, Pa
MEASURED = 0.15  # share of ambient within which differences and set-points meet it
HIGHEST, MIDDLE = 0.25, 0.35  # the same of the highest and of the usual pressures of both hoses, which loads part
FOLLOWS = 0.8  # correlation from which a pressure follows its set-point


def issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield what counts from another level than what it belongs to, and an ambient pressure that can't be."""
    yield from _ambient(log)
    for joint in log.joints or (None,):
        yield from _hoses(joint, log)


def _ambient(log: CheckedLog) -> Iterator[Issue]:
    told = {float(c.source["ambient"]): c for c in log.channels.values() if c.source.get("gauge")}
    for ambient, channel in told.items():
        text = f"counts from an ambient pressure of {channel.shown(ambient)}"
        if not LOWEST_AIR <= ambient <= HIGHEST_AIR:
            right = 'set ambient in the mapping to that of the place, such as "1.013 bar"'
            yield Issue("error", channel.name, f"{text}, which air has nowhere", right)
        elif log.machine is not None and abs(ambient - log.machine.supply.ambient_pressure) > OTHER_AIR:
            described = channel.shown(log.machine.supply.ambient_pressure)
            right = "set ambient in the mapping, or supply.ambient_pressure of the machine"
            yield Issue("warning", channel.name, f"{text}; the machine is described with {described}", right)


def _hoses(joint: str | None, log: CheckedLog) -> Iterator[Issue]:
    a, b = log.of("pressure_a", joint), log.of("pressure_b", joint)
    apart = False
    for pressure, hose in ((a, "a"), (b, "b")):
        setpoint = log.of(f"setpoint_{hose}", joint)
        if pressure is None or setpoint is None:
            continue
        off = _offset(pressure.values, setpoint.values)
        if off and _is_ambient(off, log) and _correlation(pressure.values, setpoint.values) > FOLLOWS:
            apart = True
            yield _level(pressure, setpoint, off, "error")
    measured = log.of("measured_pressure", joint)
    if a is None or b is None or apart:
        return
    if measured is not None:
        off = _offset(a.values - b.values, measured.values)
        if _is_ambient(off, log):
            yield _level(a, b, off, "error", f", and {measured.name} says otherwise")
        return
    middle = _offset(a.values, b.values)
    highest, near = a.high - b.high, log.ambient
    if abs(abs(middle) - near) < MIDDLE * near and abs(abs(highest) - near) < HIGHEST * near and middle * highest > 0.0:
        yield _level(a, b, middle, "warning", " all the time, as no load alone would have it")


def _level(one: Channel, other: Channel, off: float, severity: str, why: str = "") -> Issue:
    """Return what to say of two pressures of which one is higher by ambient pressure throughout."""
    low, high = (one, other) if off < 0.0 else (other, one)
    text = f"lies {low.shown(abs(off))} below {high.name}, about ambient pressure{why}"
    fits = (
        f"gauge = true would fit {low.name}" if not low.source.get("gauge") else f"gauge = false would fit {high.name}"
    )
    right = f"if one counts from ambient and one from vacuum, {fits}"
    return Issue("error" if severity == "error" else "warning", low.name, text, right)


def _offset(x: Array, y: Array) -> float:
    """Return the median of x - y; 0 where nothing is known of both."""
    off = (x - y)[np.isfinite(x) & np.isfinite(y)]
    return float(np.median(off)) if off.size else 0.0


def _is_ambient(off: float, log: CheckedLog) -> bool:
    return abs(abs(off) - log.ambient) < MEASURED * log.ambient


def _correlation(x: Array, y: Array) -> float:
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    if x.size < 3 or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return 0.0
    return float(np.corrcoef(x, y)[0, 1])
