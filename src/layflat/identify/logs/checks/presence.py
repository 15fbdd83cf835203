"""Joints, channels, samples and time that a log lacks, uneven clocks, and sensors that do not follow."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.identify.logs.checks.channels import Channel, CheckedLog, Issue, Severity, noise, quantum, runs, several
from layflat.motion.scenario import SIGNALS as ACTING

LEAST_SAMPLES = 10
LEAST_TIME = 2.0  # of a joint's log, s: about a move
MOSTLY = 0.5  # share of missing samples from which a channel is of no use
MANY = 0.05  # share of doubled stamps from which something is wrong with the clock
UNEVEN = 0.2  # jitter in periods that is worth knowing
SLIP = 300.0  # factor between the log's period and the controller's cycle that is no choice but a wrong unit

_UNITS_OF_TIME = (1e-9, 1e-6, 1e-3, 1.0, 60.0, 3600.0, 86400.0)  # s
TIME_FACTORS = sorted({a / b for a in _UNITS_OF_TIME for b in _UNITS_OF_TIME})
"""Factors between units of time."""

COMMANDS = ("voltage", "setpoint_a", "setpoint_b", "demand")
PRESSURES = ("measured_pressure", "pressure_a", "pressure_b")

WANTED: tuple[tuple[str, Severity, tuple[str, ...], str], ...] = (
    ("angle", "warning", ("angle",), "map its angle; nothing that moves is identifiable without it"),
    ("command", "warning", COMMANDS, "map voltage, demand or set-points: a simulation is driven by them"),
    ("pressure", "note", PRESSURES, "losses and valve are hard to separate without it"),
)
"""What a joint should have, of which signals one is enough, and what follows without any."""


def missing_issues(log: CheckedLog) -> Iterator[Issue]:
    """Joints without signals, channels without samples, a log that is too short."""
    for note in log.notes:
        yield Issue("note", "log", note)
    yield from _joints(log)
    if not any(not channel.signal.held for channel in log.filled):
        yield Issue("error", "log", "holds nothing that was measured", "map an angle, a pressure or a force at least")
    for channel in log.channels.values():
        for note in channel.source.get("notes", ()):
            lost = "are missing" in note or "is missing" in note
            yield Issue("warning" if lost else "note", channel.name, f"column {channel.source['column']}: {note}")
        yield from _samples(channel, log)
    yield from _length(log)


def _joints(log: CheckedLog) -> Iterator[Issue]:
    known = tuple(log.machine.joints) if log.machine is not None else log.joints
    for name in log.joints:
        if name not in known:
            yield Issue("error", name, "is not a joint of the machine", f"its joints are {', '.join(known)}")
    for name in known:
        if not any(channel.joint == name for channel in log.channels.values()):
            yield Issue("warning", name, "has no channel in this log", "nothing of this joint is identifiable")
            continue
        for what, severity, signals, right in WANTED:
            turned = what == "command" and log.of("torque", name) is not None  # by hand or by a rig
            if not turned and all(log.of(signal, name) is None for signal in signals):
                yield Issue(severity, name, f"has no {what}", right)


def _samples(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    absent = ~np.isfinite(channel.values)
    count = int(absent.sum())
    if not count or (channel.source.get("missing") == 0 and count < MOSTLY * absent.size):
        return  # what the clock leaves out is told with the clock
    if count == absent.size:
        yield Issue("error", channel.name, "holds no value", "leave it out of the mapping, or find out why")
        return
    holes = runs(absent)
    first, longest = max(holes, key=lambda hole: hole[1])
    share = count / absent.size
    text = (
        f"{count} of {absent.size} instants ({100 * share:.2g} %) are missing, in {len(holes)} "
        f"gap{'s' if len(holes) > 1 else ''}, the longest {longest * log.period:.3g} s from {log.time[first]:.3f} s"
    )
    severe = share > MOSTLY
    slight = share < 0.01 or channel.signal.held
    severity: Severity = "error" if severe else "note" if slight else "warning"
    yield Issue(severity, channel.name, text, "give a whole recording" if severe else "a fit leaves these times out")


def _length(log: CheckedLog) -> Iterator[Issue]:
    told = [int(channel.source["samples"]) for channel in log.filled if "samples" in channel.source]
    samples = max(told, default=log.time.size)
    duration = float(log.time[-1] - log.time[0]) if log.time.size else 0.0
    if samples < LEAST_SAMPLES:
        yield Issue("error", "log", f"holds {samples} samples", f"give {LEAST_SAMPLES} at the very least")
    elif log.joints and duration < LEAST_TIME:
        right = f"check the unit of time; else record {LEAST_TIME:g} s or more, with several moves"
        yield Issue("warning", "log", f"lasts {duration:.3g} s, which is shorter than a move", right)


def clock_issues(log: CheckedLog) -> Iterator[Issue]:
    """Return what happened to each clock, and gaps of each channel."""
    for clock in log.clocks:
        yield from _clock(clock)
    for channel in log.filled:
        if channel.source.get("gaps"):
            yield _gaps(channel)
    cycle = log.machine.controller.cycle if log.machine and log.machine.controller else 0.0
    if cycle and log.clocks and not 1.0 / SLIP < log.period / cycle < SLIP:
        text = f"a sample every {log.period:.3g} s where the controller's cycle is {cycle:.3g} s"
        ratio = cycle / log.period
        factor = min(TIME_FACTORS, key=lambda factor: abs(np.log(factor / ratio)))
        yield Issue("error", "log", text, f"check the unit of time: a factor of {factor:.5g} would fit")


def _clock(clock: dict[str, Any]) -> Iterator[Issue]:
    names = several(clock["channels"])
    if clock["reset"] is not None:
        before, after = clock["reset"]
        at = f" at sample {clock['reset_at']}" if clock.get("reset_at") else ""
        text = f"the clock jumps back from {before:.6g} s to {after:.6g} s{at}; {clock['cut']} samples are cut"
        yield Issue("warning", names, text, "the longer part is used; cut the log there to use the other")
    doubled = clock["duplicates"]
    if doubled:
        text = f"{doubled} sample{'s' if doubled > 1 else ''} with the stamp of the next one; the last of each is used"
        coarse = doubled > MANY * clock["samples"]
        right = "the clock is too coarse, or the unit of time wrong" if coarse else "write each sample once"
        yield Issue("warning" if coarse else "note", names, text, right)
    if clock["undated"]:
        several_of_them = f"{clock['undated']} samples" if clock["undated"] > 1 else "1 sample"
        text = f"{several_of_them} without stamp, first sample {clock.get('first_undated', 0)}, left out"
        yield Issue("note", names, text)
    period, jitter = clock["period"], clock["jitter"]
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


RAIL_SHARE = 0.005
RAIL_SAMPLES = 8  # share and number of the samples at exactly one extreme from which it may be a rail
RAIL_RUN = 3  # samples on end at it
ABRUPT = 0.25  # speed of arriving there, over a fast speed of the signal: what comes to rest by itself is slower
STILL = 6.0  # range in standard deviations of the noise below which a signal does not move
NOTHING_MOVES = Issue("error", "log", "nothing in it moves more than its noise", "record a motion")
STEADY = ("brake", *(name for name, row in ACTING.items() if not row.by_joint))  # what is usually constant


def constant_issues(log: CheckedLog) -> Iterator[Issue]:
    """Constant channels and rails, of what was measured."""
    for channel in log.filled:
        if channel.signal.held or channel.signal.name in STEADY:
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
    """Return whether a signal runs into a standstill, or out of it, at speed."""
    steps = np.abs(np.diff(values[np.isfinite(values)]))
    fast = float(np.percentile(steps[steps > 0.0], 90.0))
    into = np.diff(values[max(first - 3, 0) : first])
    out = np.diff(values[first + length : first + length + 3])
    limit = max(ABRUPT * fast, 3.0 * quantum(values[np.isfinite(values)]))
    return any(side.size == 2 and np.isfinite(side).all() and abs(side.mean()) > limit for side in (into, out))


def stationary_issues(log: CheckedLog) -> Iterator[Issue]:
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
    """Return whether a signal moves by more than its noise."""
    known = channel.known
    span = float(np.percentile(known, 99.0) - np.percentile(known, 1.0))
    return span > STILL * noise(known)
