"""Pressures of one joint with different zeros, one gauge and one absolute; and wrong ambient pressures.

A pressure is compared with a measured difference, a set-point that it follows, or the pressure of the other hose.
"""

from collections.abc import Iterator

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.checks.channels import Channel, CheckedLog, Issue

MAX_AMBIENT, MIN_AMBIENT = 1.1e5, 4.5e4  # of air from below sea level to 6000 m, Pa
AMBIENT_TOLERANCE = 5e3  # difference from the machine's ambient pressure that weather does not explain, Pa
MEASURED_TOLERANCE = 0.15  # of an offset from ambient pressure, relative: by a difference or set-point
HIGHEST_TOLERANCE = 0.25  # the same, by the highest pressures of both hoses, which differ by the load
MEDIAN_TOLERANCE = 0.35  # the same, by their medians
MIN_FOLLOWING_CORRELATION = 0.8  # of a pressure that follows its set-point


def level_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield issues of pressures whose zero differs from that of related ones, and of impossible ambient pressures."""
    yield from _ambient_issues(log)
    for joint in log.joints or (None,):
        yield from _hose_issues(joint, log)


def _ambient_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield an error for each impossible ambient pressure of the log, a warning for one that the machine has not."""
    channel_by_ambient = {float(c.source["ambient"]): c for c in log.channels.values() if c.source.get("gauge")}
    for ambient, channel in channel_by_ambient.items():
        text = f"counts from an ambient pressure of {channel.format_value(ambient)}"
        if not MIN_AMBIENT <= ambient <= MAX_AMBIENT:
            right = 'set ambient in the mapping to that of the place, such as "1.013 bar"'
            yield Issue("error", channel.name, f"{text}, which air has nowhere", right)
        elif log.machine is not None and abs(ambient - log.machine.supply.ambient_pressure) > AMBIENT_TOLERANCE:
            described = channel.format_value(log.machine.supply.ambient_pressure)
            right = "set ambient in the mapping, or supply.ambient_pressure of the machine"
            yield Issue("warning", channel.name, f"{text}; the machine is described with {described}", right)


def _hose_issues(joint: str | None, log: CheckedLog) -> Iterator[Issue]:
    """Yield issues of a joint's pressures whose zero differs from that of set-point, difference or other hose."""
    a, b = log.find_channel("pressure_a", joint), log.find_channel("pressure_b", joint)
    different_zeros = False
    for pressure, hose in ((a, "a"), (b, "b")):
        setpoint = log.find_channel(f"setpoint_{hose}", joint)
        if pressure is None or setpoint is None:
            continue
        offset = _median_offset(pressure.values, setpoint.values)
        if (
            offset
            and _is_ambient(offset, log)
            and _correlation(pressure.values, setpoint.values) > MIN_FOLLOWING_CORRELATION
        ):
            different_zeros = True
            yield _level_issue(pressure, setpoint, offset, "error")
    measured = log.find_channel("measured_pressure", joint)
    if a is None or b is None or different_zeros:
        return
    if measured is not None:
        offset = _median_offset(a.values - b.values, measured.values)
        if _is_ambient(offset, log):
            yield _level_issue(a, b, offset, "error", f", and {measured.name} says otherwise")
        return
    middle = _median_offset(a.values, b.values)
    highest, ambient = a.high - b.high, log.ambient
    if (
        abs(abs(middle) - ambient) < MEDIAN_TOLERANCE * ambient
        and abs(abs(highest) - ambient) < HIGHEST_TOLERANCE * ambient
        and middle * highest > 0.0
    ):
        yield _level_issue(a, b, middle, "warning", " all the time, as no load alone would have it")


def _level_issue(pressure: Channel, other: Channel, offset: float, severity: str, why: str = "") -> Issue:
    """Return the issue of two pressures that differ by about ambient pressure throughout.

    Args:
        pressure: pressure of one hose.
        other: pressure or set-point that belongs to it.
        offset: median of `pressure` less `other`, Pa.
        severity: "error" or "warning".
        why: clause on the evidence.
    """
    low, high = (pressure, other) if offset < 0.0 else (other, pressure)
    text = f"lies {low.format_value(abs(offset))} below {high.name}, about ambient pressure{why}"
    advice = (
        f"gauge = true would fit {low.name}" if not low.source.get("gauge") else f"gauge = false would fit {high.name}"
    )
    right = f"if one counts from ambient and one from vacuum, {advice}"
    return Issue("error" if severity == "error" else "warning", low.name, text, right)


def _median_offset(x: Array, y: Array) -> float:
    """Return the median of x - y; 0 without common samples."""
    offsets = (x - y)[np.isfinite(x) & np.isfinite(y)]
    return float(np.median(offsets)) if offsets.size else 0.0


def _is_ambient(offset: float, log: CheckedLog) -> bool:
    """Return whether the size of an offset (Pa) is about ambient pressure."""
    return abs(abs(offset) - log.ambient) < MEASURED_TOLERANCE * log.ambient


def _correlation(x: Array, y: Array) -> float:
    """Return the correlation over common samples; 0 for fewer than three or a constant signal."""
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    if x.size < 3 or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return 0.0
    return float(np.corrcoef(x, y)[0, 1])
