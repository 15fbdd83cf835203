"""What isn't there: joints, channels, samples."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from layflat.identify.logs.checks.bench import Bench, Channel, runs
from layflat.identify.logs.finding import LogFinding, Severity

LEAST_SAMPLES = 10
LEAST_TIME = 2.0
"""Of a joint's log, s: about a move."""
MOSTLY = 0.5
"""Share of missing samples from which a channel is of no use."""

COMMANDS = ("voltage", "setpoint_a", "setpoint_b", "demand")
PRESSURES = ("measured_pressure", "pressure_a", "pressure_b")


def findings(bench: Bench) -> Iterator[LogFinding]:
    """Joints without signals, channels without samples, a log that is too short."""
    yield from _joints(bench)
    if not any(not channel.signal.held for channel in bench.filled):
        yield LogFinding("error", "log", "holds nothing that was measured", "map an angle, a pressure or a force at least")
    for channel in bench.channels.values():
        yield from _samples(channel, bench)
    yield from _length(bench)


def _joints(bench: Bench) -> Iterator[LogFinding]:
    known = tuple(bench.machine.joints) if bench.machine is not None else bench.joints
    for name in bench.joints:
        if name not in known:
            yield LogFinding("error", name, "is no joint of the machine", f"its joints are {', '.join(known)}")
    for name in known:
        if not any(channel.joint == name for channel in bench.channels.values()):
            yield LogFinding("warning", name, "has no channel in this log", "nothing can be told of this joint")
            continue
        wanted = {"no angle": ("angle",), "no command": COMMANDS, "no pressure": PRESSURES}
        follows = {
            "no angle": "map its angle; nothing that moves can be told without",
            "no command": "map voltage, demand or set-points: a simulation is driven by them",
            "no pressure": "losses and valve are hard to tell apart without",
        }
        for what, signals in wanted.items():
            if what == "no command" and bench.of("torque", name) is not None:
                continue  # turned by hand or by a rig
            if all(bench.of(signal, name) is None for signal in signals):
                yield LogFinding("note" if what == "no pressure" else "warning", name, f"has {what}", follows[what])


def _samples(channel: Channel, bench: Bench) -> Iterator[LogFinding]:
    absent = ~np.isfinite(channel.values)
    count = int(absent.sum())
    if not count or (channel.identified.get("missing") == 0 and count < MOSTLY * absent.size):
        return  # what the clock leaves out is told with the clock
    if count == absent.size:
        yield LogFinding("error", channel.name, "holds no value", "leave it out of the mapping, or find out why")
        return
    holes = runs(absent)
    first, longest = max(holes, key=lambda hole: hole[1])
    share = count / absent.size
    text = (
        f"{100 * share:.2g} % is missing, in {len(holes)} run{'s' if len(holes) > 1 else ''}, the longest "
        f"{longest * bench.period:.3g} s from {bench.time[first]:.3f} s"
    )
    severe = share > MOSTLY
    slight = share < 0.01 or channel.signal.held
    severity: Severity = "error" if severe else "note" if slight else "warning"
    yield LogFinding(severity, channel.name, text, "give a whole recording" if severe else "a fit leaves these times out")


def _length(bench: Bench) -> Iterator[LogFinding]:
    told = [int(channel.identified["samples"]) for channel in bench.filled if "samples" in channel.identified]
    samples = max(told, default=bench.time.size)
    duration = float(bench.time[-1] - bench.time[0]) if bench.time.size else 0.0
    if samples < LEAST_SAMPLES:
        yield LogFinding("error", "log", f"holds {samples} samples", f"give {LEAST_SAMPLES} at the very least")
    elif bench.joints and duration < LEAST_TIME:
        right = f"check the unit of time; else record {LEAST_TIME:g} s or more, with several moves"
        yield LogFinding("warning", "log", f"lasts {duration:.3g} s, which is shorter than a move", right)
