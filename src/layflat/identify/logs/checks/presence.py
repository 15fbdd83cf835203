"""Missing joints, channels, samples and times, uneven clocks, and sensors that are stuck or at their rail."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.identify.logs.checks.channels import (
    Channel,
    CheckedLog,
    Issue,
    Severity,
    find_runs,
    name_several,
    noise_deviation,
    smallest_step,
)
from layflat.motion.scenario import SIGNALS as ACTING

MIN_SAMPLES = 10
MIN_DURATION = 2.0  # of a log of a joint, s: about a move
MAX_MISSING_FRACTION = 0.5  # of missing samples: a channel with more is of no use
MAX_DUPLICATE_FRACTION = 0.05  # of duplicate stamps: with more the clock is too coarse
MAX_JITTER_RATIO = 0.2  # jitter over period that is worth a note
MAX_CYCLE_RATIO = 300.0  # between the log's period and the control cycle: more is a wrong unit of time

_UNITS_OF_TIME = (1e-9, 1e-6, 1e-3, 1.0, 60.0, 3600.0, 86400.0)  # s
TIME_FACTORS = sorted({a / b for a in _UNITS_OF_TIME for b in _UNITS_OF_TIME})
"""Factors between units of time, in rising order."""

COMMANDS = ("voltage", "setpoint_a", "setpoint_b", "demand")
PRESSURES = ("measured_pressure", "pressure_a", "pressure_b")

NEEDED_SIGNALS: tuple[tuple[str, Severity, tuple[str, ...], str], ...] = (
    ("angle", "warning", ("angle",), "map its angle; nothing that moves is identifiable without it"),
    ("command", "warning", COMMANDS, "map voltage, demand or set-points: a simulation is driven by them"),
    ("pressure", "note", PRESSURES, "losses and valve are hard to separate without it"),
)
"""Kinds of signals that a joint needs: name, severity of lacking it, signals of which one is enough, advice."""


def missing_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield notes on the reading, issues of lacking signals, measurements and samples, and of a short log."""
    for note in log.notes:
        yield Issue("note", "log", note)
    yield from _joint_issues(log)
    if not any(not channel.signal.held for channel in log.filled):
        yield Issue("error", "log", "holds nothing that was measured", "map an angle, a pressure or a force at least")
    for channel in log.channels.values():
        for note in channel.source.get("notes", ()):
            lost = "are missing" in note or "is missing" in note
            yield Issue("warning" if lost else "note", channel.name, f"column {channel.source['column']}: {note}")
        yield from _sample_issues(channel, log)
    yield from _length_issues(log)


def _joint_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield issues of unknown joints, joints without channels, and joints without needed signals."""
    joints = tuple(log.machine.joints) if log.machine is not None else log.joints
    for name in log.joints:
        if name not in joints:
            yield Issue("error", name, "is not a joint of the machine", f"its joints are {', '.join(joints)}")
    for name in joints:
        if not any(channel.joint == name for channel in log.channels.values()):
            yield Issue("warning", name, "has no channel in this log", "nothing of this joint is identifiable")
            continue
        for need, severity, signals, right in NEEDED_SIGNALS:
            is_turned = need == "command" and log.find_channel("torque", name) is not None  # turned by hand or by a rig
            if not is_turned and all(log.find_channel(signal, name) is None for signal in signals):
                yield Issue(severity, name, f"has no {need}", right)


def _sample_issues(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    """Yield an issue if instants of a channel lack samples; how severe it is depends on their fraction.

    There is none where the file has all samples and less than half of the instants are missing: see `clock_issues`.
    """
    missing = ~np.isfinite(channel.values)
    count = int(missing.sum())
    if not count or (channel.source.get("missing") == 0 and count < MAX_MISSING_FRACTION * missing.size):
        return  # samples that the clock leaves out are reported with the clock
    if count == missing.size:
        yield Issue("error", channel.name, "holds no value", "leave it out of the mapping, or find out why")
        return
    holes = find_runs(missing)
    first, longest = max(holes, key=lambda hole: hole[1])
    share = count / missing.size
    text = (
        f"{count} of {missing.size} instants ({100 * share:.2g} %) are missing, in {len(holes)} "
        f"gap{'s' if len(holes) > 1 else ''}, the longest {longest * log.period:.3g} s from {log.time[first]:.3f} s"
    )
    severe = share > MAX_MISSING_FRACTION
    slight = share < 0.01 or channel.signal.held
    severity: Severity = "error" if severe else "note" if slight else "warning"
    yield Issue(severity, channel.name, text, "give a whole recording" if severe else "a fit leaves these times out")


def _length_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield an issue if the log has too few samples, or is shorter than a move."""
    counts = [int(channel.source["samples"]) for channel in log.filled if "samples" in channel.source]
    samples = max(counts, default=log.time.size)
    duration = float(log.time[-1] - log.time[0]) if log.time.size else 0.0
    if samples < MIN_SAMPLES:
        yield Issue("error", "log", f"holds {samples} samples", f"give {MIN_SAMPLES} at the very least")
    elif log.joints and duration < MIN_DURATION:
        right = f"check the unit of time; else record {MIN_DURATION:g} s or more, with several moves"
        yield Issue("warning", "log", f"lasts {duration:.3g} s, which is shorter than a move", right)


def clock_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield issues of clocks with faults, channels with gaps, and a period that does not suit the control cycle."""
    for clock in log.clocks:
        yield from _clock_faults(clock)
    for channel in log.filled:
        if channel.source.get("gaps"):
            yield _gap_issue(channel)
    cycle = log.machine.controller.cycle if log.machine and log.machine.controller else 0.0
    if cycle and log.clocks and not 1.0 / MAX_CYCLE_RATIO < log.period / cycle < MAX_CYCLE_RATIO:
        text = f"a sample every {log.period:.3g} s where the controller's cycle is {cycle:.3g} s"
        ratio = cycle / log.period
        factor = min(TIME_FACTORS, key=lambda factor: abs(np.log(factor / ratio)))
        yield Issue("error", "log", text, f"check the unit of time: a factor of {factor:.5g} would fit")


def _clock_faults(clock: dict[str, Any]) -> Iterator[Issue]:
    """Yield issues of resets, duplicate stamps, missing stamps and jitter of a clock, from its attributes."""
    names = name_several(clock["channels"])
    if clock["reset"] is not None:
        before, after = clock["reset"]
        place = f" at sample {clock['reset_at']}" if clock.get("reset_at") else ""
        text = f"the clock jumps back from {before:.6g} s to {after:.6g} s{place}; {clock['cut']} samples are cut"
        yield Issue("warning", names, text, "the longer part is used; cut the log there to use the other")
    doubled = clock["duplicates"]
    if doubled:
        text = f"{doubled} sample{'s' if doubled > 1 else ''} with the stamp of the next one; the last of each is used"
        coarse = doubled > MAX_DUPLICATE_FRACTION * clock["samples"]
        right = "the clock is too coarse, or the unit of time wrong" if coarse else "write each sample once"
        yield Issue("warning" if coarse else "note", names, text, right)
    if clock["undated"]:
        several_of_them = f"{clock['undated']} samples" if clock["undated"] > 1 else "1 sample"
        text = f"{several_of_them} without stamp, first sample {clock.get('first_undated', 0)}, left out"
        yield Issue("note", names, text)
    period, jitter = clock["period"], clock["jitter"]
    if jitter > MAX_JITTER_RATIO * period > 0.0:
        text = f"stamps jitter by {jitter:.3g} s rms about a period of {period:.3g} s"
        yield Issue("note", names, text, "resampled; a log written in real time would be more exact")


def _gap_issue(channel: Channel) -> Issue:
    """Return a warning for a channel's gaps, or a note if the channel is a command, which is held there."""
    since, until = channel.source["longest_gap"]
    count = channel.source["gaps"]
    text = f"{count} gap{'s' if count > 1 else ''}, the longest of {until - since:.3g} s from {since:.3f} s"
    if channel.signal.held:
        return Issue("note", channel.name, text, "the command is held there")
    return Issue("warning", channel.name, text, "left open: nothing is interpolated there")


RAIL_FRACTION = 0.005
RAIL_SAMPLES = 8  # fraction and number of samples at exactly one extreme from which it may be a rail
RAIL_RUN = 3  # consecutive samples at it
MIN_ABRUPT_RATIO = 0.25  # speed before a rail over a fast speed of the signal: free motion stops slower
MIN_MOTION_RATIO = 6.0  # range over standard deviation of the noise above which a signal moves
NOTHING_MOVES = Issue("error", "log", "nothing in it moves more than its noise", "record a motion")
CONSTANT_SIGNALS = ("brake", *(name for name, row in ACTING.items() if not row.by_joint))  # usually constant


def constant_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield issues of measured channels that are constant or at a rail, but for `CONSTANT_SIGNALS`."""
    for channel in log.filled:
        if channel.signal.held or channel.signal.name in CONSTANT_SIGNALS:
            continue
        if np.ptp(channel.samples) == 0.0:
            yield _constant_issue(channel, log)
        else:
            yield from _rail_issues(channel, log)


def _constant_issue(channel: Channel, log: CheckedLog) -> Issue:
    """Return the issue of a constant channel: a warning, but an error if another channel of its joint moves.

    A pressure beside a moving torque or force, without commands, gets a note: it may be held.
    """
    others = [other for other in log.filled if other.joint == channel.joint and other is not channel]
    moving = [
        channel_beside
        for channel_beside in others
        if smallest_step(channel_beside.samples) > 0.0
        and np.ptp(channel_beside.samples) > 10.0 * noise_deviation(channel_beside.samples)
    ]
    text = f"is exactly {channel.format_value(float(channel.samples[0]))} all the time"
    if not moving:
        return Issue("warning", channel.name, text, "a sensor that lives has some noise: check that it is connected")
    has_load = any(other.signal.name in {"torque", "force"} for other in others)
    if channel.signal.kind == u.PRESSURE and has_load and not any(other.signal.held for other in others):
        return Issue("note", channel.name, text, "right for a loop at constant pressure; else a dead sensor")
    return Issue("error", channel.name, f"{text} while {moving[0].name} moves", "a dead sensor: leave the channel out")


def _rail_issues(channel: Channel, log: CheckedLog) -> Iterator[Issue]:
    """Yield a warning for each extreme at which a signal stops abruptly, and stays for several samples."""
    values = channel.values
    if np.unique(channel.samples).size < 20:
        return
    for extreme, word in ((np.nanmin(values), "low"), (np.nanmax(values), "high")):
        at_extreme = values == extreme
        plateaus = [(first, length) for first, length in find_runs(at_extreme) if length >= RAIL_RUN]
        count = sum(length for _, length in plateaus)
        if count < max(RAIL_SAMPLES, RAIL_FRACTION * values.size) or not any(
            _is_abrupt(values, first, length) for first, length in plateaus
        ):
            continue
        first = plateaus[0][0]
        text = (
            f"stands at its {word}est value, {channel.format_value(float(extreme))}, for "
            f"{100 * count / values.size:.2g} % of the samples, first from {log.time[first]:.3f} s"
        )
        right = "a sensor at its rail, or a joint at its stop: use a wider range, or leave these times out"
        yield Issue("warning", channel.name, text, right)


def _is_abrupt(values: Array, first: int, length: int) -> bool:
    """Return whether a signal stops, or starts, at speed: `length` equal samples from sample `first` on."""
    steps = np.abs(np.diff(values[np.isfinite(values)]))
    fast = float(np.percentile(steps[steps > 0.0], 90.0))
    into = np.diff(values[max(first - 3, 0) : first])
    out = np.diff(values[first + length : first + length + 3])
    limit = max(MIN_ABRUPT_RATIO * fast, 3.0 * smallest_step(values[np.isfinite(values)]))
    return any(side.size == 2 and np.isfinite(side).all() and abs(side.mean()) > limit for side in (into, out))


def stationary_issues(log: CheckedLog) -> Iterator[Issue]:
    """Yield issues of signals that move no more than their noise (`NOTHING_MOVES` for all) and of constant commands."""
    measured = [c for c in log.filled if not c.signal.held and c.signal.name not in CONSTANT_SIGNALS]
    stationary = [channel for channel in measured if not is_moving(channel)]
    if measured and len(stationary) == len(measured):
        yield NOTHING_MOVES
        return
    for channel in stationary:
        if np.ptp(channel.samples) == 0.0:
            continue  # reported as a dead sensor
        text = f"moves no more than its noise, about {channel.format_value(channel.high)}"
        driven = channel.signal.name in {"angle", "position", "force"}
        yield Issue("warning" if driven else "note", channel.name, text, "nothing is identifiable from it")
    commands = [c for c in log.filled if c.signal.held and c.signal.name not in CONSTANT_SIGNALS]
    for joint in dict.fromkeys(channel.joint for channel in commands):
        of_joint = [channel for channel in commands if channel.joint == joint]
        if all(np.ptp(channel.samples) == 0.0 for channel in of_joint):
            names = " and ".join(channel.name for channel in of_joint)
            yield Issue(
                "warning", of_joint[0].name, f"{names} never change", "command a motion: steps, sweeps or noise"
            )


def is_moving(channel: Channel) -> bool:
    """Return whether a signal's range, 1 % left out at each end, exceeds `MIN_MOTION_RATIO` times its noise."""
    samples = channel.samples
    span = float(np.percentile(samples, 99.0) - np.percentile(samples, 1.0))
    return span > MIN_MOTION_RATIO * noise_deviation(samples)
