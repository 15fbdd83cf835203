"""The clock of a log: what was left out, what is missing, how even it is."""

from __future__ import annotations

from collections.abc import Iterator

from layflat.identify.logs.checks.channels import Channel, CheckedLog
from layflat.identify.logs.issue import Issue, several

MANY = 0.05
"""Share of doubled stamps from which something is wrong with the clock."""
UNEVEN = 0.2
"""Jitter in periods that is worth knowing."""
SLIP = 300.0
"""Factor between the log's period and the controller's cycle that is no choice but a wrong unit."""


def issues(log: CheckedLog) -> Iterator[Issue]:
    """What happened to each clock, and gaps of each channel."""
    for clock in log.clocks:
        yield from _clock(clock)
    for channel in log.filled:
        if channel.source.get("gaps"):
            yield _gaps(channel)
    cycle = log.machine.controller.cycle if log.machine and log.machine.controller else 0.0
    if cycle and log.clocks and not 1.0 / SLIP < log.period / cycle < SLIP:
        text = f"a sample every {log.period:.3g} s where the controller's cycle is {cycle:.3g} s"
        yield Issue("error", "log", text, f"check the unit of time: a factor of {cycle / log.period:.3g} would fit")


def _clock(clock: dict[str, object]) -> Iterator[Issue]:
    names = several([str(name) for name in _list(clock["channels"])])
    samples = _whole(clock["samples"])
    if clock["reset"] is not None:
        before, after = (float(str(stamp)) for stamp in _list(clock["reset"]))
        text = f"the clock jumps back from {before:.6g} s to {after:.6g} s; {clock['cut']} samples are cut"
        yield Issue("warning", names, text, "the longer part is used; cut the log there to use the other")
    doubled = _whole(clock["duplicates"])
    if doubled:
        text = f"{doubled} sample{'s' if doubled > 1 else ''} with the stamp of the next one; the last of each is used"
        coarse = doubled > MANY * samples
        right = "the clock is too coarse, or the unit of time wrong" if coarse else "write each sample once"
        yield Issue("warning" if coarse else "note", names, text, right)
    if clock["undated"]:
        yield Issue("note", names, f"{clock['undated']} samples without stamp are left out", "")
    period, jitter = float(str(clock["period"])), float(str(clock["jitter"]))
    if jitter > UNEVEN * period > 0.0:
        text = f"stamps jitter by {jitter:.3g} s rms about a period of {period:.3g} s"
        yield Issue("note", names, text, "resampled; a log written in real time would be more exact")


def _gaps(channel: Channel) -> Issue:
    since, until = channel.source["longest_gap"]
    count = channel.source["gaps"]
    text = f"{count} gap{'s' if count > 1 else ''}, the longest of {until - since:.3g} s from {since:.3f} s"
    if channel.signal.held:
        return Issue("note", channel.name, text, "the command is held there")
    return Issue("warning", channel.name, text, "left open: nothing is interpolated there")


def _list(value: object) -> list[object]:
    assert isinstance(value, list)
    return value


def _whole(value: object) -> int:
    return int(str(value))
