"""Sensors that don't follow: dead channels, those that stand at a rail, and those that hardly move."""

from collections.abc import Iterator

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.identify.logs.checks.channels import Channel, CheckedLog, Issue, noise, quantum, runs

RAIL_SHARE = 0.005
RAIL_SAMPLES = 8  # share and number of the samples at exactly one extreme from which it may be a rail
RAIL_RUN = 3  # samples on end at it
ABRUPT = 0.25  # speed of arriving there, over a fast speed of the signal: what comes to rest by itself is slower
STILL = 6.0  # range in standard deviations of the noise below which a signal does not move
NOTHING_MOVES = Issue("error", "log", "nothing in it moves more than its noise", "record a motion")
STEADY = ("supply", "payload", "brake")  # what is usually constant


def issues(log: CheckedLog) -> Iterator[Issue]:
    """Constant channels and rails, of what was measured."""
    for channel in log.filled:
        if channel.signal.held or channel.name == "supply":
            continue
        if np.ptp(channel.known) == 0.0:
            yield _constant(channel, log)
        else:
            yield from _rails(channel, log)


def _constant(channel: Channel, log: CheckedLog) -> Issue:
    beside = [other for other in log.filled if other.joint == channel.joint and other is not channel]
    lively = [one for one in beside if quantum(one.known) > 0.0 and np.ptp(one.known) > 10.0 * noise(one.known)]
    text = f"is exactly {channel.shown(float(channel.known[0]))} all the time"
    if not lively:
        return Issue("warning", channel.name, text, "a sensor that lives has some noise: check that it is connected")
    effort = any(other.signal.name in {"torque", "force"} for other in beside)
    if channel.signal.kind == u.PRESSURE and effort and not any(other.signal.held for other in beside):
        return Issue("note", channel.name, text, "right for a loop at constant pressure; else a dead sensor")
    return Issue("error", channel.name, f"{text} while {lively[0].name} moves", "a dead sensor: leave the channel out")


def _rails(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    values = channel.values
    if np.unique(channel.known).size < 20:
        return
    for extreme, word in ((np.nanmin(values), "low"), (np.nanmax(values), "high")):
        at = values == extreme
        stays = [(first, length) for first, length in runs(at) if length >= RAIL_RUN]
        count = sum(length for _, length in stays)
        if count < max(RAIL_SAMPLES, RAIL_SHARE * values.size) or not any(
            _abrupt(values, first, length) for first, length in stays
        ):
            continue
        first = stays[0][0]
        text = (
            f"stands at its {word}est value, {channel.shown(float(extreme))}, for {100 * count / values.size:.2g} % "
            f"of the samples, first from {log.time[first]:.3f} s"
        )
        right = "a sensor at its rail, or a joint at its stop: use a wider range, or leave these times out"
        yield Issue("warning", channel.name, text, right)


def _abrupt(values: Array, first: int, length: int) -> bool:
    """Whether a signal runs into a standstill, or out of it, at speed."""
    steps = np.abs(np.diff(values[np.isfinite(values)]))
    fast = float(np.percentile(steps[steps > 0.0], 90.0))
    into = np.diff(values[max(first - 3, 0) : first])
    out = np.diff(values[first + length : first + length + 3])
    limit = max(ABRUPT * fast, 3.0 * quantum(values[np.isfinite(values)]))
    return any(side.size == 2 and np.isfinite(side).all() and abs(side.mean()) > limit for side in (into, out))


def still(log: CheckedLog) -> Iterator[Issue]:
    """Signals and commands that do not move more than their noise: they identify nothing."""
    measured = [c for c in log.filled if not c.signal.held and c.signal.name not in STEADY]
    quiet = [channel for channel in measured if not moves(channel)]
    if measured and len(quiet) == len(measured):
        yield NOTHING_MOVES
        return
    for channel in quiet:
        if np.ptp(channel.known) == 0.0:
            continue  # said to be dead
        text = f"moves no more than its noise, about {channel.shown(channel.high)}"
        driven = channel.signal.name in {"angle", "position", "force"}
        yield Issue("warning" if driven else "note", channel.name, text, "nothing is identifiable from it")
    commands = [c for c in log.filled if c.signal.held and c.signal.name not in STEADY]
    for joint in dict.fromkeys(channel.joint for channel in commands):
        mine = [channel for channel in commands if channel.joint == joint]
        if all(np.ptp(channel.known) == 0.0 for channel in mine):
            names = " and ".join(channel.name for channel in mine)
            yield Issue("warning", mine[0].name, f"{names} never change", "command a motion: steps, sweeps or noise")


def moves(channel: Channel) -> bool:
    """Whether a signal moves by more than its noise."""
    known = channel.known
    span = float(np.percentile(known, 99.0) - np.percentile(known, 1.0))
    return span > STILL * noise(known)
