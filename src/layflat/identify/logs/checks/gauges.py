"""Gauge pressures that are taken for absolute ones, and the reverse: told by what vented air and the supply have."""

from collections.abc import Iterator

import numpy as np

from layflat.identify.logs.checks.channels import Channel, CheckedLog, Issue, runs

VENTED = 0.15  # share of ambient pressure about which vented air is found, with all errors of sensors
CLOSE = 0.04  # the same for a level that lasts
LEVEL = 1e3  # pressures so close together are one level, Pa
LASTING = 0.1  # time that a level has to last, s


def issues(log: CheckedLog) -> Iterator[Issue]:
    """Absolute pressures that count from the wrong level."""
    found = (counts_wrong(channel, log) for channel in log.filled if channel.signal.absolute)
    yield from (issue for issue in found if issue is not None)


def pressure_span(channel: Channel, log: CheckedLog) -> tuple[float, float]:
    """Range of an absolute pressure above ambient, Pa."""
    return channel.low - log.ambient, channel.high - log.ambient


def counts_wrong(channel: Channel, log: CheckedLog) -> Issue | None:
    """What to say of a pressure that counts from the wrong level; None if it doesn't, or if nothing can be told."""
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
    """Whether a signal stays at a level for a while."""
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
