"""Impossible ranges of signals, with the unit that explains them; and gauge pressures read as absolute."""

from collections.abc import Callable, Iterator
from math import pi

import numpy as np

from layflat.description import units as u
from layflat.identify.logs.checks.channels import Channel, CheckedLog, Issue, Severity, find_runs
from layflat.identify.logs.vocabulary import unit_conversion

VENTED_TOLERANCE = 0.15  # of vented air about ambient pressure, relative, with all errors of sensors
LASTING_LEVEL_TOLERANCE = 0.04  # the same for a level that lasts, relative
LEVEL_WIDTH = 1e3  # of one level, Pa
MIN_LEVEL_TIME = 0.1  # that a level has to last, s


def gauge_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield issues of absolute pressures with a wrong zero: gauge read as absolute, or the reverse."""
    issues = (zero_issue(channel, log) for channel in log.filled if channel.signal.absolute)
    yield from (issue for issue in issues if issue is not None)


def gauge_span(channel: Channel, log: CheckedLog) -> tuple[float, float]:
    """Return lower and upper end of an absolute pressure's range above ambient, Pa."""
    return channel.low - log.ambient, channel.high - log.ambient


def zero_issue(channel: Channel, log: CheckedLog) -> Issue | None:
    """Return the issue of a pressure with a wrong zero; None if it is right, or can't be judged."""
    low, high = gauge_span(channel, log)
    ambient = log.ambient
    supply = log.supply_gauge if channel.signal.name != "pressure" else None
    gauge = bool(channel.source.get("gauge", False))
    max_pressure = 1.1 * supply if supply is not None else np.inf
    min_pressure = 0.25 * supply if supply is not None else 3e4
    span = f"{channel.format_value(channel.low)} to {channel.format_value(channel.high)} absolute"
    if (
        not gauge
        and -1.1 * ambient < low < -VENTED_TOLERANCE * ambient
        and min_pressure <= high + ambient <= max_pressure
    ):
        right = "it counts from ambient pressure: gauge = true would fit"
        return Issue("error", channel.name, f"{span}: below ambient", right)
    if not gauge:
        return _supply_level_issue(channel, supply, span, log.period)
    right = "it is absolute already: gauge = false would fit"
    if (
        supply is not None
        and high > max_pressure
        and low - ambient > -VENTED_TOLERANCE * ambient
        and high - ambient <= 1.02 * supply
    ):
        beyond = f"{span} where the supply has {channel.format_value(supply + ambient)}"
        return Issue("error", channel.name, beyond, right)
    near_twice = abs(channel.low - 2.0 * ambient) < LASTING_LEVEL_TOLERANCE * ambient
    if near_twice and _stays_at_level(channel, channel.low, log.period) and high - low > 0.5 * ambient:
        text = f"{span}; its lowest level is twice ambient pressure"
        return Issue("warning", channel.name, text, f"if that is vented air, {right}")
    return None


def _stays_at_level(channel: Channel, level: float, period: float) -> bool:
    """Return whether a signal stays within `LEVEL_WIDTH` of a level (Pa) for `MIN_LEVEL_TIME`, and 3 samples."""
    longest = max((length for _, length in find_runs(np.abs(channel.values - level) < LEVEL_WIDTH)), default=0)
    return longest >= 3 and longest * period >= MIN_LEVEL_TIME


def _supply_level_issue(channel: Channel, supply: float | None, span: str, period: float) -> Issue | None:
    """Return the issue of an absolute pressure that lasts at the supply's gauge pressure `supply`, Pa; else None.

    Set-points, and the channel of the supply itself, have none.
    """
    if supply is None or channel.signal.held or channel.name == "supply":
        return None
    if abs(channel.high - supply) > 0.02 * supply or not _stays_at_level(channel, channel.high, period):
        return None
    text = f"{span}; its highest level is the supply's gauge pressure"
    return Issue("warning", channel.name, text, "if that is full supply pressure, gauge = true would fit")


MAX_RANGE_RATIO = 1.15  # of a range over the stroke or full voltage: more is no play
MAX_SUPPLY_RATIO = 1.1  # of a pressure over the supply's gauge pressure: no load or noise explains more
MIN_SUPPLY_RATIO = 0.2  # of the highest pressure over the supply's gauge pressure: less is strange
USUAL_MAX_PRESSURES = (1.5e5, 1.2e6)  # limits of the highest gauge pressure in hoses, Pa, for an unknown supply

CONFUSABLE_UNITS: dict[u.Quantity | None, dict[str, float]] = {
    u.PRESSURE: {"Pa": 1.0, "mbar": 100.0, "kPa": 1e3, "psi": 6894.757, "bar": 1e5, "MPa": 1e6},
    u.ANGLE: {"deg": pi / 180.0, "rad": 1.0, "mrad": 1e-3},
    u.VOLTAGE: {"mV": 1e-3, "V": 1.0},
    None: {"%": 0.01, "1": 1.0},
}
"""Units that are often confused, by kind, and their size in SI; of several that fit the first is reported."""

UNIT_ADVICE = "check unit and scale"


def unit_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield issues of signals with impossible ranges, with the unit that would fit as advice."""
    for channel in log.filled:
        by_kind = _pressure_issues if channel.signal.kind == u.PRESSURE else None
        check_range = RANGE_CHECKS.get(channel.signal.name, by_kind)
        if check_range is not None:
            yield from check_range(channel, log)
    for joint in log.joints or (None,):
        yield from _demand_issues(joint, log)


def _unit_slip(
    channel: Channel, text: str, fits: Callable[[float], bool], otherwise: str = "", *, severity: Severity = "error"
) -> Iterator[Issue]:
    """Yield an issue that advises the unit that fits in place of the mapping's; else the advice `otherwise`, if any.

    Args:
        channel: channel with the impossible range.
        text: text of the issue.
        fits: returns whether values multiplied by a factor are possible.
        otherwise: advice where no unit fits; without it there is no issue then.
        severity: severity of the issue.
    """
    unit = str(channel.source.get("unit", channel.signal.unit))
    stated_size = unit_conversion(unit, channel.signal)[0]
    factors = {other: value / stated_size for other, value in CONFUSABLE_UNITS.get(channel.signal.kind, {}).items()}
    fitting = [other for other, factor in factors.items() if abs(factor - 1.0) > 1e-6 and fits(factor)]
    if fitting:
        otherwise = f'unit = "{fitting[0]}" instead of "{unit}" would fit (factor {factors[fitting[0]]:.4g})'
    if otherwise:
        yield Issue(severity, channel.name, text, otherwise)


def _fits_between(value: float, lowest: float, highest: float) -> Callable[[float], bool]:
    """Return a test whether value x factor lies above `lowest` and not above `highest`."""
    return lambda factor: lowest < factor * value <= highest


def _angle_issues(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    """Yield an issue if an angle lies beyond the stroke (or 2.1 pi if unknown), or is too small for its pressures.

    One that is too small is an issue only where another unit would fit.
    """
    low, high = channel.low, channel.high
    span, greatest = high - low, max(-low, high)
    joint = log.machine.joints.get(str(channel.joint)) if log.machine is not None else None
    text = f"{channel.format_value(low)} to {channel.format_value(high)}"
    if joint is None:
        if greatest > 2.1 * pi:
            yield from _unit_slip(
                channel, f"{text}: more than a turn", _fits_between(greatest, 0.05, 2.1 * pi), UNIT_ADVICE
            )
        return
    stroke = joint.stops.mechanical_stroke
    beyond = f"{text} where the joint has a stroke of {channel.format_value(stroke)}"
    if span > MAX_RANGE_RATIO * stroke:
        yield from _unit_slip(
            channel, beyond, _fits_between(span, 0.02 * stroke, MAX_RANGE_RATIO * stroke), UNIT_ADVICE
        )
    elif greatest > MAX_RANGE_RATIO * stroke / 2.0:
        centre = channel.format_value((low + high) / 2)
        middle = f"zero is the middle of the stroke: set offset (the log's middle is {centre})"
        yield Issue("error", channel.name, beyond, middle)
    elif _is_loaded(channel, log):
        fits = _fits_between(span, max(0.1 * stroke, 20.0 * span), MAX_RANGE_RATIO * stroke)
        yield from _unit_slip(channel, f"{text} though the pressures move much", fits, severity="warning")


def _is_loaded(channel: Channel, log: CheckedLog) -> bool:
    """Return whether the pressure difference of a joint varies by more than `MIN_SUPPLY_RATIO` of the supply.

    False where either is not known.
    """
    difference, supply = log.difference(channel.joint), log.supply_gauge
    if difference is None or supply is None:
        return False
    return bool(np.nanpercentile(difference, 99.0) - np.nanpercentile(difference, 1.0) > MIN_SUPPLY_RATIO * supply)


def _pressure_issues(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    """Yield an issue if a pressure lies below vacuum or ambient, above the supply, or is too small.

    There is none for a pressure with a `zero_issue`, nor for a small one unless another unit would fit; differential
    ones have `_difference_issues`.
    """
    if not channel.signal.absolute:
        yield from _difference_issues(channel, log)
        return
    if zero_issue(channel, log) is not None:
        return  # a matter of gauge and absolute, not of the unit
    low, high = gauge_span(channel, log)
    supply = log.supply_gauge if channel.signal.name != "pressure" else None
    ambient, gauge, hose = log.ambient, bool(channel.source.get("gauge", False)), channel.signal.by_joint

    def is_possible(factor: float) -> bool:
        """Return whether the range times a factor lies above ambient pressure, and its end near the supply."""
        lowest, highest = (factor * end if gauge else factor * (end + ambient) - ambient for end in (low, high))
        min_highest, max_highest = (
            (0.3 * supply, MAX_SUPPLY_RATIO * supply) if supply is not None else USUAL_MAX_PRESSURES
        )
        return lowest > -0.15 * ambient and min_highest <= highest <= max_highest

    text = f"{channel.format_value(low + ambient)} to {channel.format_value(high + ambient)} absolute"
    if low < -ambient - 2e3:
        yield from _unit_slip(channel, f"{text}: below vacuum", is_possible, "check sign, unit and offset")
    elif low < -0.15 * ambient and hose:
        yield from _unit_slip(channel, f"{text}: below ambient", is_possible, "check unit, offset and gauge")
    elif supply is not None and high > MAX_SUPPLY_RATIO * supply:
        yield from _unit_slip(
            channel, f"{text} where the supply has {channel.format_value(supply + ambient)}", is_possible, UNIT_ADVICE
        )
    elif supply is not None and high < MIN_SUPPLY_RATIO * supply:
        little = f"{text}: hardly anything of the supply's pressure"
        yield from _unit_slip(channel, little, is_possible, severity="warning")
    elif supply is None and hose and not 1e4 < high < 2e6:
        yield from _unit_slip(channel, f"{text}: strange for a hose", is_possible, severity="warning")


def _difference_issues(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    """Yield an issue if a differential pressure exceeds the supply's gauge pressure by 10 %, or is below 1 % of it.

    There is none for an unknown supply, nor below 1 % unless another unit would fit.
    """
    supply, greatest = log.supply_gauge, max(-channel.low, channel.high)
    if supply is None:
        return
    text = f"reaches {channel.format_value(greatest)} where the supply has {channel.format_value(supply)} above ambient"
    if greatest > MAX_SUPPLY_RATIO * supply:
        yield from _unit_slip(
            channel, text, _fits_between(greatest, 0.05 * supply, MAX_SUPPLY_RATIO * supply), UNIT_ADVICE
        )
    elif greatest < 0.01 * supply:
        fits = _fits_between(greatest, 0.1 * supply, MAX_SUPPLY_RATIO * supply)
        yield from _unit_slip(channel, text, fits, severity="warning")


def _voltage_issues(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    """Yield an issue if a voltage goes beyond twice the valve's range, or its median is far from the centre.

    There is none without a machine that has a valve.
    """
    if log.machine is None or log.machine.valve is None:
        return
    centre, full = log.machine.valve.centre_voltage, log.machine.valve.volts_to_full
    low, high, median = channel.low, channel.high, float(np.median(channel.samples))
    reach = MAX_RANGE_RATIO * full
    text = f"{low:.3g} V to {high:.3g} V where the valve takes {centre - full:g} V to {centre + full:g} V"
    if low < centre - 2.0 * full or high > centre + 2.0 * full:
        otherwise = "check unit, scale and offset"
        yield from _unit_slip(
            channel, text, lambda f: centre - reach <= f * low and f * high <= centre + reach, otherwise
        )
    elif abs(median - centre) > 0.6 * full:
        right = f"at rest a valve has its centre, {centre:g} V: check unit and offset"
        text = f"{text}; its median is {median:.3g} V"
        yield from _unit_slip(channel, text, lambda f: abs(f * median - centre) < 0.2 * full, right, severity="warning")


def _fraction_issues(channel: Channel, _: CheckedLog) -> Iterator[Issue]:
    """Yield an error if a fraction lies outside 0 to 1 by more than 0.05."""
    low, high = channel.low, channel.high
    if low < -0.05 or high > 1.05:
        text, otherwise = f"{low:.3g} to {high:.3g}", "a share lies from 0 to 1"
        yield from _unit_slip(channel, text, lambda f: low >= 0.0 and f * high <= 1.05, otherwise)


def _temperature_issues(channel: Channel, _: CheckedLog) -> Iterator[Issue]:
    """Yield an error if a temperature, K, below 60 or above 480 shows that degC and K were confused."""
    text = f"{channel.low:.4g} K to {channel.high:.4g} K"
    if channel.low < 60.0:
        yield Issue("error", channel.name, text, 'no gas is so cold: unit = "degC" would add 273.15 K')
    elif channel.low > 480.0:
        yield Issue("error", channel.name, text, 'no hose is so hot: unit = "K" would take 273.15 K away')


def _demand_issues(joint: str | None, log: CheckedLog) -> Iterator[Issue]:
    """Yield an error if an angle follows its demand, but is 20 times as large or as small."""
    angle, demand = log.find_channel("angle", joint), log.find_channel("demand", joint)
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


RANGE_CHECKS = {
    "angle": _angle_issues,
    "demand": _angle_issues,
    "voltage": _voltage_issues,
    "temperature": _temperature_issues,
    "brake": _fraction_issues,
}
"""Check of the range by signal; pressures of all kinds have `_pressure_issues`."""
