"""Units that can not be: beyond stroke or supply, and the slip that explains it; gauge taken for absolute pressures."""

from collections.abc import Callable, Iterator
from math import pi

import numpy as np

from layflat.description import units as u
from layflat.identify.logs.checks.channels import Channel, CheckedLog, Issue, Severity, runs
from layflat.identify.logs.vocabulary import conversion

VENTED = 0.15  # share of ambient pressure about which vented air is found, with all errors of sensors
CLOSE = 0.04  # the same for a level that lasts
LEVEL = 1e3  # pressures so close together are one level, Pa
LASTING = 0.1  # time that a level has to last, s


def gauge_issues(log: CheckedLog) -> Iterator[Issue]:
    """Absolute pressures that count from the wrong level."""
    found = (counts_wrong(channel, log) for channel in log.filled if channel.signal.absolute)
    yield from (issue for issue in found if issue is not None)


def pressure_span(channel: Channel, log: CheckedLog) -> tuple[float, float]:
    """Range of an absolute pressure above ambient, Pa."""
    return channel.low - log.ambient, channel.high - log.ambient


def counts_wrong(channel: Channel, log: CheckedLog) -> Issue | None:
    """Return a remark on a pressure that counts from the wrong level; None if it doesn't, or if nothing can be told."""
    low, high = pressure_span(channel, log)
    ambient = log.ambient
    supply = log.supply_gauge if channel.signal.name != "pressure" else None
    gauge = bool(channel.source.get("gauge", False))
    most = 1.1 * supply if supply is not None else np.inf
    enough = 0.25 * supply if supply is not None else 3e4
    span = f"{channel.shown(channel.low)} to {channel.shown(channel.high)} absolute"
    if not gauge and -1.1 * ambient < low < -VENTED * ambient and enough <= high + ambient <= most:
        right = "it counts from ambient pressure: gauge = true would fit"
        return Issue("error", channel.name, f"{span}: below ambient", right)
    if not gauge:
        return _at_supply(channel, supply, span, log.period)
    right = "it is absolute already: gauge = false would fit"
    if supply is not None and high > most and low - ambient > -VENTED * ambient and high - ambient <= 1.02 * supply:
        beyond = f"{span} where the supply has {channel.shown(supply + ambient)}"
        return Issue("error", channel.name, beyond, right)
    twice = abs(channel.low - 2.0 * ambient) < CLOSE * ambient
    if twice and _lasts(channel, channel.low, log.period) and high - low > 0.5 * ambient:
        text = f"{span}; its lowest level is twice ambient pressure"
        return Issue("warning", channel.name, text, f"if that is vented air, {right}")
    return None


def _lasts(channel: Channel, level: float, period: float) -> bool:
    """Return whether a signal stays at a level for a while."""
    longest = max((length for _, length in runs(np.abs(channel.values - level) < LEVEL)), default=0)
    return longest >= 3 and longest * period >= LASTING


def _at_supply(channel: Channel, supply: float | None, span: str, period: float) -> Issue | None:
    """A pressure said to be absolute whose highest level lasts and is the supply's gauge pressure to the per cent."""
    if supply is None or channel.signal.held or channel.name == "supply":
        return None
    if abs(channel.high - supply) > 0.02 * supply or not _lasts(channel, channel.high, period):
        return None
    text = f"{span}; its highest level is the supply's gauge pressure"
    return Issue("warning", channel.name, text, "if that is full supply pressure, gauge = true would fit")


BEYOND = 1.15  # share of a stroke or of full voltage that is no play any more
BEYOND_SUPPLY = 1.1  # share of the supply's gauge pressure that no load and no noise explains
LITTLE = 0.2  # share of the supply's gauge pressure below which pressures would be strangely low
USUAL = (1.5e5, 1.2e6)  # highest gauge pressures that are usual in hoses, Pa, where the supply is not known

KNOWN: dict[u.Quantity | None, dict[str, float]] = {
    u.PRESSURE: {"Pa": 1.0, "mbar": 100.0, "kPa": 1e3, "psi": 6894.757, "bar": 1e5, "MPa": 1e6},
    u.ANGLE: {"deg": pi / 180.0, "rad": 1.0, "mrad": 1e-3},
    u.VOLTAGE: {"mV": 1e-3, "V": 1.0},
    None: {"%": 0.01, "1": 1.0},
}
"""Units that get mixed up, by kind, in SI; of several that would fit the first is told."""

CHECK = "check unit and scale"


def unit_issues(log: CheckedLog) -> Iterator[Issue]:
    """Ranges that are out of reason, with the unit or factor that would fit."""
    for channel in log.filled:
        usual = _pressure if channel.signal.kind == u.PRESSURE else None
        ask = ASKED.get(channel.signal.name, usual)
        if ask is not None:
            yield from ask(channel, log)
    for joint in log.joints or (None,):
        yield from _demanded(joint, log)


def _slipped(
    channel: Channel, text: str, fits: Callable[[float], bool], otherwise: str = "", *, severity: Severity = "error"
) -> Iterator[Issue]:
    """An issue with the unit, instead of that of the mapping, with which `fits(factor)` holds; else with `otherwise`.

    Where there is nothing else to say, there is no issue.
    """
    unit = str(channel.source.get("unit", channel.signal.unit))
    own = conversion(unit, channel.signal)[0]
    factors = {other: value / own for other, value in KNOWN.get(channel.signal.kind, {}).items()}
    found = [other for other, factor in factors.items() if abs(factor - 1.0) > 1e-6 and fits(factor)]
    if found:
        otherwise = f'unit = "{found[0]}" instead of "{unit}" would fit (factor {factors[found[0]]:.4g})'
    if otherwise:
        yield Issue(severity, channel.name, text, otherwise)


def _between(value: float, above: float, most: float) -> Callable[[float], bool]:
    return lambda factor: above < factor * value <= most


def _angle(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    low, high = channel.low, channel.high
    span, most = high - low, max(-low, high)
    joint = log.machine.joints.get(str(channel.joint)) if log.machine is not None else None
    text = f"{channel.shown(low)} to {channel.shown(high)}"
    if joint is None:
        if most > 2.1 * pi:
            yield from _slipped(channel, f"{text}: more than a turn", _between(most, 0.05, 2.1 * pi), CHECK)
        return
    stroke = joint.stops.mechanical_stroke
    beyond = f"{text} where the joint has a stroke of {channel.shown(stroke)}"
    if span > BEYOND * stroke:
        yield from _slipped(channel, beyond, _between(span, 0.02 * stroke, BEYOND * stroke), CHECK)
    elif most > BEYOND * stroke / 2.0:
        middle = f"zero is the middle of the stroke: set offset (the log's middle is {channel.shown((low + high) / 2)})"
        yield Issue("error", channel.name, beyond, middle)
    elif _strains(channel, log):
        fits = _between(span, max(0.1 * stroke, 20.0 * span), BEYOND * stroke)
        yield from _slipped(channel, f"{text} though the pressures move much", fits, severity="warning")


def _strains(channel: Channel, log: CheckedLog) -> bool:
    """Return whether the pressure difference of a joint swings by more than a little."""
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
    ambient, gauge, hose = log.ambient, bool(channel.source.get("gauge", False)), channel.signal.by_joint

    def fits(factor: float) -> bool:
        least, most = (factor * end if gauge else factor * (end + ambient) - ambient for end in (low, high))
        few, top = (0.3 * supply, BEYOND_SUPPLY * supply) if supply is not None else USUAL
        return least > -0.15 * ambient and few <= most <= top

    text = f"{channel.shown(low + ambient)} to {channel.shown(high + ambient)} absolute"
    if low < -ambient - 2e3:
        yield from _slipped(channel, f"{text}: below vacuum", fits, "check sign, unit and offset")
    elif low < -0.15 * ambient and hose:
        yield from _slipped(channel, f"{text}: below ambient", fits, "check unit, offset and gauge")
    elif supply is not None and high > BEYOND_SUPPLY * supply:
        yield from _slipped(channel, f"{text} where the supply has {channel.shown(supply + ambient)}", fits, CHECK)
    elif supply is not None and high < LITTLE * supply:
        little = f"{text}: hardly anything of the supply's pressure"
        yield from _slipped(channel, little, fits, severity="warning")
    elif supply is None and hose and not 1e4 < high < 2e6:
        yield from _slipped(channel, f"{text}: strange for a hose", fits, severity="warning")


def _difference(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    supply, most = log.supply_gauge, max(-channel.low, channel.high)
    if supply is None:
        return
    text = f"reaches {channel.shown(most)} where the supply has {channel.shown(supply)} above ambient"
    if most > BEYOND_SUPPLY * supply:
        yield from _slipped(channel, text, _between(most, 0.05 * supply, BEYOND_SUPPLY * supply), CHECK)
    elif most < 0.01 * supply:
        fits = _between(most, 0.1 * supply, BEYOND_SUPPLY * supply)
        yield from _slipped(channel, text, fits, severity="warning")


def _voltage(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    if log.machine is None or log.machine.valve is None:
        return
    centre, full = log.machine.valve.centre_voltage, log.machine.valve.volts_to_full
    low, high, median = channel.low, channel.high, float(np.median(channel.known))
    reach = BEYOND * full
    text = f"{low:.3g} V to {high:.3g} V where the valve takes {centre - full:g} V to {centre + full:g} V"
    if low < centre - 2.0 * full or high > centre + 2.0 * full:
        otherwise = "check unit, scale and offset"
        yield from _slipped(
            channel, text, lambda f: centre - reach <= f * low and f * high <= centre + reach, otherwise
        )
    elif abs(median - centre) > 0.6 * full:
        right = f"at rest a valve has its centre, {centre:g} V: check unit and offset"
        text = f"{text}; its median is {median:.3g} V"
        yield from _slipped(channel, text, lambda f: abs(f * median - centre) < 0.2 * full, right, severity="warning")


def _share(channel: Channel, _: CheckedLog) -> Iterator[Issue]:
    low, high = channel.low, channel.high
    if low < -0.05 or high > 1.05:
        text, otherwise = f"{low:.3g} to {high:.3g}", "a share lies from 0 to 1"
        yield from _slipped(channel, text, lambda f: low >= 0.0 and f * high <= 1.05, otherwise)


def _temperature(channel: Channel, _: CheckedLog) -> Iterator[Issue]:
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


ASKED = {"angle": _angle, "demand": _angle, "voltage": _voltage, "temperature": _temperature, "brake": _share}
"""By signal; pressures of all kinds are asked the same."""
