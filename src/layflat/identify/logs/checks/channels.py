"""What a check finds in a log."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array, Dataset
from layflat.errors import InputError
from layflat.identify.logs.vocabulary import AMBIENT, SIGNALS, Signal, channel_name
from layflat.machine import Machine

Severity = Literal["error", "warning", "note"]

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True)
class Issue:
    """A place in a log that is wrong, doubtful or worth knowing."""

    severity: Severity  # "error" (no fit makes sense), "warning" (look at it) or "note"
    channel: str  # signal and joint, such as "pressure_a.elbow"; "log" for the whole
    text: str  # what was found, with values
    right: str = ""  # what would be right, or follows


def ordered(issues: Iterable[Issue]) -> list[Issue]:
    """The worst first; what is the same of several channels is said once."""
    together: dict[Issue, list[str]] = {}
    for issue in issues:
        together.setdefault(replace(issue, channel=""), []).append(issue.channel)
    merged = [replace(issue, channel=several(channels)) for issue, channels in together.items()]
    return sorted(merged, key=lambda issue: SEVERITIES.index(issue.severity))


def several(channels: Sequence[str]) -> str:
    """Several channels in a few words."""
    return " and ".join(channels) if len(channels) <= 2 else f"{channels[0]} and {len(channels) - 1} more"


def refuse(issues: Sequence[Issue], where: str = "log") -> None:
    """Stop at a log with errors: raise InputError with the first one, and how many there are."""
    errors = [issue for issue in issues if issue.severity == "error"]
    if errors:
        first, more = errors[0], len(errors) - 1
        told = f" (and {more} more error{'s' if more > 1 else ''})" if more else ""
        raise InputError(f"{first.text}{told}", where=f"{where}: {first.channel}", right=first.right)


TAIL = 0.5  # per cent of the samples at both ends that don't count for a range: single wild samples


@dataclass(frozen=True)
class Channel:
    """One signal of one joint, SI, NaN where there is no sample; and what the log's attributes say of its column."""

    name: str
    signal: Signal
    joint: str | None
    values: Array
    source: dict[str, Any]

    @cached_property
    def known(self) -> Array:
        """The samples that there are."""
        return self.values[np.isfinite(self.values)]

    @property
    def low(self) -> float:
        """Low end of the range, single wild samples left out."""
        return float(np.percentile(self.known, TAIL))

    @property
    def high(self) -> float:
        """High end of the range, single wild samples left out."""
        return float(np.percentile(self.known, 100.0 - TAIL))

    def shown(self, value: float) -> str:
        """A value with a unit that people read."""
        unit, size = self.signal.shown
        return f"{value / size:.3g} {unit}"


@dataclass(frozen=True)
class CheckedLog:
    """A log, what its attributes say of its clocks, and what is known of where it was made."""

    channels: dict[str, Channel]
    time: Array
    period: float
    joints: tuple[str, ...]
    clocks: list[dict[str, Any]]
    machine: Machine | None
    notes: tuple[str, ...] = ()  # on how its file was read

    @cached_property
    def filled(self) -> list[Channel]:
        """Channels with two samples or more."""
        return [channel for channel in self.channels.values() if channel.known.size > 1]

    def of(self, signal: str, joint: str | None = None) -> Channel | None:
        """A channel with samples; None where there is none."""
        return next((channel for channel in self.filled if channel.name == channel_name(signal, joint)), None)

    @property
    def ambient(self) -> float:
        """Absolute, Pa."""
        if self.machine is not None:
            return self.machine.supply.ambient_pressure
        told = [float(c.source["ambient"]) for c in self.channels.values() if "ambient" in c.source]
        return told[0] if told else AMBIENT

    @property
    def supply_gauge(self) -> float | None:
        """Pressure of the supply above ambient, Pa: the machine's, else the log's."""
        if self.machine is not None:
            return self.machine.supply.pressure_gauge
        supply = self.of("supply")
        gauge = float(np.median(supply.known)) - self.ambient if supply is not None else 0.0
        return gauge if gauge > 0.0 else None

    def difference(self, joint: str | None) -> Array | None:
        """Pressure of hose A less hose B, Pa, (samples,): from both, else as it was measured."""
        a, b = self.of("pressure_a", joint), self.of("pressure_b", joint)
        if a is not None and b is not None:
            return a.values - b.values
        measured = self.of("measured_pressure", joint)
        return measured.values if measured is not None else None


def checked_log(log: Dataset, description: object | None) -> CheckedLog:
    """Channels of a log with what its attributes and a description say."""
    told = json.loads(log.attrs.get("log_columns", "{}"))
    joints = tuple(str(name) for name in log["joint"].values) if "joint" in log.coords else ()
    channels = {}
    for signal in SIGNALS.values():
        if signal.name not in log:
            continue
        values = log[signal.name]
        columns: dict[str | None, Any] = {None: values}
        if "joint" in values.dims:
            columns = {name: values.isel(joint=i) for i, name in enumerate(joints)}
        for joint, column in columns.items():
            name = channel_name(signal.name, joint)
            if told and name not in told:
                continue  # of another joint only
            numbers = np.asarray(column.values, dtype=np.float64)
            channels[name] = Channel(name, signal, joint, numbers, told.get(name, {}))
    time = np.asarray(log["time"].values, dtype=np.float64)
    period = float(log.attrs.get("log_period", np.median(np.diff(time)) if time.size > 1 else 0.0))
    machine = description if isinstance(description, Machine) else None
    notes = tuple(json.loads(log.attrs.get("log_notes", "[]")))
    return CheckedLog(channels, time, period, joints, json.loads(log.attrs.get("log_clocks", "[]")), machine, notes)


def smoothed(values: Array, samples: int) -> Array:
    """Moving average, (size - samples + 1,)."""
    return np.convolve(values, np.full(samples, 1.0 / samples), "valid") if samples > 1 else values


def without_spikes(values: Array) -> Array:
    """Every sample replaced by the median of itself and its neighbours.

    A steady rise or fall stays as it is, and single samples far off go: an element that slips would take a spike for
    a motion to and fro, and forget where the motion reversed.
    """
    padded = np.concatenate([values[:1], values, values[-1:]])
    return np.asarray(np.median(np.stack([padded[:-2], padded[1:-1], padded[2:]]), axis=0))


def noise(values: Array) -> float:
    """Standard deviation of the noise of a signal that moves slowly beside its samples, from second differences."""
    if values.size < 3:
        return 0.0
    spread = np.median(np.abs(np.diff(values, 2))) * 1.4826 / np.sqrt(6.0)
    return float(max(spread, quantum(values) / 2.0))


def quantum(values: Array) -> float:
    """The smallest step between samples: that of a converter, if there is one; rounding of the last digits is none."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > 1e-9 * max(float(np.abs(values).max(initial=0.0)), 1e-300)]
    return float(steps.min(initial=np.inf)) if steps.size else 0.0


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First sample and length of each run of true flags."""
    edges = np.diff(np.concatenate(([0], flags.astype(np.int8), [0])))
    firsts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return [(int(first), int(end - first)) for first, end in zip(firsts, ends, strict=True)]
