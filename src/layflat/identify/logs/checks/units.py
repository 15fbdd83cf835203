"""Units that can't be: angles beyond the stroke, pressures beyond the supply, and the slip that would explain them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import pi

import numpy as np

from layflat.description import units as u
from layflat.identify.logs.checks.channels import Channel, CheckedLog
from layflat.identify.logs.checks.gauges import counts_wrong, pressure_span
from layflat.identify.logs.issue import Issue
from layflat.identify.logs.signals import conversion

BEYOND = 1.15
"""Share of a stroke or of full voltage that is no play any more."""
BEYOND_SUPPLY = 1.1
"""Share of the supply's gauge pressure that no load and no noise explains."""
LITTLE = 0.2
"""Share of the supply's gauge pressure below which pressures would be strangely low."""

USUAL = (1.5e5, 1.2e6)
"""Highest gauge pressures that are usual in hoses, Pa, where the supply is not known."""

KNOWN: dict[u.Quantity | None, dict[str, float]] = {
    u.PRESSURE: {"Pa": 1.0, "mbar": 100.0, "kPa": 1e3, "psi": 6894.757, "bar": 1e5, "MPa": 1e6},
    u.ANGLE: {"deg": pi / 180.0, "rad": 1.0, "mrad": 1e-3},
    u.VOLTAGE: {"mV": 1e-3, "V": 1.0},
    None: {"%": 0.01, "1": 1.0},
}
"""Units that get mixed up, by kind, in SI; of several that would fit the first is told."""


def issues(log: CheckedLog) -> Iterator[Issue]:
    """Ranges that are out of reason, with the unit or factor that would fit."""
    for channel in log.filled:
        name = channel.signal.name
        if name in {"angle", "demand"}:
            yield from _angle(channel, log)
        elif channel.signal.kind == u.PRESSURE:
            yield from _pressure(channel, log)
        elif name == "voltage":
            yield from _voltage(channel, log)
        elif name == "temperature":
            yield from _temperature(channel)
        elif name == "brake":
            yield from _share(channel)
    for joint in log.joints or (None,):
        yield from _demanded(joint, log)


def slip(channel: Channel, fits: Callable[[float], bool]) -> str:
    """The unit, instead of that of the mapping, with which `fits(factor)` holds; empty where there is none."""
    unit = str(channel.source.get("unit", channel.signal.unit))
    own = conversion(unit, channel.signal)[0]
    for other, value in KNOWN.get(channel.signal.kind, {}).items():
        factor = value / own
        if abs(factor - 1.0) > 1e-6 and fits(factor):
            return f'unit = "{other}" instead of "{unit}" would fit (factor {factor:.4g})'
    return ""


def _angle(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    low, high = channel.low, channel.high
    joint = log.machine.joints.get(str(channel.joint)) if log.machine is not None else None
    text = f"{channel.shown(low)} to {channel.shown(high)}"
    if joint is None:
        if max(-low, high) > 2.1 * pi:
            fits = slip(channel, lambda f: 0.05 < f * max(-low, high) <= 2.1 * pi)
            yield Issue("error", channel.name, f"{text}: more than a turn", fits or "check unit and scale")
        return
    stroke = joint.stops.mechanical_stroke
    of = f"a stroke of {channel.shown(stroke)}"
    if high - low > BEYOND * stroke:
        fits = slip(channel, lambda f: 0.02 * stroke < f * (high - low) <= BEYOND * stroke)
        yield Issue("error", channel.name, f"{text} where the joint has {of}", fits or "check unit and scale")
    elif max(-low, high) > BEYOND * stroke / 2.0:
        middle = f"zero is the middle of the stroke: set offset (the log's middle is {channel.shown((low + high) / 2)})"
        yield Issue("error", channel.name, f"{text} where the joint has {of}", middle)
    elif _strains(channel, log):
        fits = slip(channel, lambda f: f > 20.0 and 0.1 * stroke < f * (high - low) <= BEYOND * stroke)
        if fits:
            yield Issue("warning", channel.name, f"{text} though the pressures move much", fits)


def _strains(channel: Channel, log: CheckedLog) -> bool:
    """Whether the pressure difference of a joint swings by more than a little."""
    difference, supply = log.difference(channel.joint), log.supply_gauge
    if difference is None or supply is None:
        return False
    return bool(np.nanpercentile(difference, 99.0) - np.nanpercentile(difference, 1.0) > LITTLE * supply)


def _pressure(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    if not channel.signal.absolute:
        yield from _difference(channel, log)
        return
    if counts_wrong(channel, log) is not None:
        return  # a matter of gauge and absolute, not of the unit
    low, high = pressure_span(channel, log)
    supply = log.supply_gauge if channel.signal.name != "pressure" else None
    gauge = bool(channel.source.get("gauge", False))
    ambient = log.ambient

    def scaled(factor: float) -> tuple[float, float]:
        if gauge:
            return factor * low, factor * high
        return factor * (low + ambient) - ambient, factor * (high + ambient) - ambient

    def fits(factor: float) -> bool:
        least, most = scaled(factor)
        few, top = (0.3 * supply, BEYOND_SUPPLY * supply) if supply is not None else USUAL
        return least > -0.15 * ambient and few <= most <= top

    text = f"{channel.shown(low + ambient)} to {channel.shown(high + ambient)} absolute"
    right = slip(channel, fits)
    if low < -ambient - 2e3:
        yield Issue("error", channel.name, f"{text}: below vacuum", right or "check sign, unit and offset")
    elif low < -0.15 * ambient and channel.signal.by_joint:
        yield Issue("error", channel.name, f"{text}: below ambient", right or "check unit, offset and gauge")
    elif supply is not None and high > BEYOND_SUPPLY * supply:
        beyond = f"{text} where the supply has {channel.shown(supply + ambient)}"
        yield Issue("error", channel.name, beyond, right or "check unit and scale")
    elif supply is not None and high < LITTLE * supply and right:
        yield Issue("warning", channel.name, f"{text}: hardly anything of the supply's pressure", right)
    elif supply is None and channel.signal.by_joint and not 1e4 < high < 2e6 and right:
        yield Issue("warning", channel.name, f"{text}: strange for a hose", right)


def _difference(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    supply, most = log.supply_gauge, max(-channel.low, channel.high)
    if supply is None:
        return
    text = f"reaches {channel.shown(most)} where the supply has {channel.shown(supply)} above ambient"
    if most > BEYOND_SUPPLY * supply:
        fits = slip(channel, lambda f: 0.05 * supply < f * most <= BEYOND_SUPPLY * supply)
        yield Issue("error", channel.name, text, fits or "check unit and scale")
    elif most < 0.01 * supply:
        fits = slip(channel, lambda f: 0.1 * supply < f * most <= BEYOND_SUPPLY * supply)
        if fits:
            yield Issue("warning", channel.name, text, fits)


def _voltage(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    if log.machine is None or log.machine.valve is None:
        return
    centre, full = log.machine.valve.centre_voltage, log.machine.valve.volts_to_full
    low, high = channel.low, channel.high
    text = f"{low:.3g} V to {high:.3g} V where the valve takes {centre - full:g} V to {centre + full:g} V"
    if low < centre - 2.0 * full or high > centre + 2.0 * full:
        fits = slip(channel, lambda f: centre - BEYOND * full <= f * low and f * high <= centre + BEYOND * full)
        yield Issue("error", channel.name, text, fits or "check unit, scale and offset")
        return
    median = float(np.median(channel.known))
    if abs(median - centre) > 0.6 * full:
        fits = slip(channel, lambda f: abs(f * median - centre) < 0.2 * full)
        right = f"at rest a valve has its centre, {centre:g} V: check unit and offset"
        yield Issue("warning", channel.name, f"{text}; its median is {median:.3g} V", fits or right)


def _share(channel: Channel) -> Iterator[Issue]:
    low, high = channel.low, channel.high
    if low < -0.05 or high > 1.05:
        fits = slip(channel, lambda f: low >= 0.0 and f * high <= 1.05)
        yield Issue("error", channel.name, f"{low:.3g} to {high:.3g}", fits or "a share lies from 0 to 1")


def _temperature(channel: Channel) -> Iterator[Issue]:
    text = f"{channel.low:.4g} K to {channel.high:.4g} K"
    if channel.low < 60.0:
        yield Issue("error", channel.name, text, 'no gas is so cold: unit = "degC" would add 273.15 K')
    elif channel.low > 480.0:
        yield Issue("error", channel.name, text, 'no hose is so hot: unit = "K" would take 273.15 K away')


def _demanded(joint: str | None, log: CheckedLog) -> Iterator[Issue]:
    """An angle that follows its demand, but in another unit."""
    angle, demand = log.of("angle", joint), log.of("demand", joint)
    if angle is None or demand is None:
        return
    both = np.isfinite(angle.values) & np.isfinite(demand.values)
    x, y = demand.values[both], angle.values[both]
    if x.size < 3 or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        return
    ratio = float(np.std(y) / np.std(x))
    if np.corrcoef(x, y)[0, 1] > 0.8 and not 1.0 / 20.0 < ratio < 20.0:
        text = f"moves {ratio:.3g} times as far as {demand.name} asks"
        yield Issue("error", angle.name, text, "one of them is in deg and the other in rad: check both units")
