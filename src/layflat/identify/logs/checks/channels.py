"""Channels of a log that is checked, the issues that checks find in them, and statistics of signals."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array, Dataset
from layflat.errors import InputError
from layflat.identify.logs.vocabulary import AMBIENT, SIGNALS, LogSignal, channel_name
from layflat.machine import Machine

Severity = Literal["error", "warning", "note"]

SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True)
class Issue:
    """Problem in a log, or a note on it."""

    severity: Severity  # "error" (no fit makes sense), "warning" (needs a look) or "note"
    channel: str  # signal and joint, such as "pressure_a.elbow"; "log" for the whole
    text: str  # problem, with values
    right: str = ""  # advice, or consequence


def merge_issues(issues: Iterable[Issue]) -> list[Issue]:
    """Return issues sorted by severity, the worst first; equal ones of several channels are merged."""
    together: dict[Issue, list[str]] = {}
    for issue in issues:
        together.setdefault(replace(issue, channel=""), []).append(issue.channel)
    merged = [replace(issue, channel=name_several(channels)) for issue, channels in together.items()]
    return sorted(merged, key=lambda issue: SEVERITIES.index(issue.severity))


def name_several(channels: Sequence[str]) -> str:
    """Return the names of channels in a few words, such as "angle.elbow and 3 more"."""
    return " and ".join(channels) if len(channels) <= 2 else f"{channels[0]} and {len(channels) - 1} more"


def raise_first_error(issues: Sequence[Issue], where: str = "log") -> None:
    """Raise InputError with the first error among issues, and the number of others; return if there is none."""
    errors = [issue for issue in issues if issue.severity == "error"]
    if errors:
        first, more = errors[0], len(errors) - 1
        others = f" (and {more} more error{'s' if more > 1 else ''})" if more else ""
        raise InputError(f"{first.text}{others}", where=f"{where}: {first.channel}", right=first.right)


TAIL_PERCENT = 0.5  # per cent of the samples that are left out at each end of a range, as single ones may be wild


@dataclass(frozen=True)
class Channel:
    """Signal of one joint, SI, (samples,), NaN where there is no sample; and its entry in the log's attributes."""

    name: str
    signal: LogSignal
    joint: str | None
    values: Array
    source: dict[str, Any]

    @cached_property
    def samples(self) -> Array:
        """Finite samples."""
        return self.values[np.isfinite(self.values)]

    @property
    def low(self) -> float:
        """Lower end of the range: `TAIL_PERCENT` of the samples lie below."""
        return float(np.percentile(self.samples, TAIL_PERCENT))

    @property
    def high(self) -> float:
        """Upper end of the range: `TAIL_PERCENT` of the samples lie above."""
        return float(np.percentile(self.samples, 100.0 - TAIL_PERCENT))

    def format_value(self, value: float) -> str:
        """Return a value (SI) as text with three significant digits and the signal's display unit."""
        unit, size = self.signal.display_unit
        return f"{value / size:.3g} {unit}"


@dataclass(frozen=True)
class CheckedLog:
    """Log with the attributes of its channels and clocks, and the machine that it was recorded on."""

    channels: dict[str, Channel]
    time: Array
    period: float
    joints: tuple[str, ...]
    clocks: list[dict[str, Any]]
    machine: Machine | None
    notes: tuple[str, ...] = ()  # on the reading of its file

    @cached_property
    def filled(self) -> list[Channel]:
        """Channels with two samples or more."""
        return [channel for channel in self.channels.values() if channel.samples.size > 1]

    def find_channel(self, signal: str, joint: str | None = None) -> Channel | None:
        """Return the channel of a signal and joint; None where it has fewer than two samples."""
        return next((channel for channel in self.filled if channel.name == channel_name(signal, joint)), None)

    @property
    def ambient(self) -> float:
        """Absolute ambient pressure, Pa: the machine's, else the log's, else a standard atmosphere."""
        if self.machine is not None:
            return self.machine.supply.ambient_pressure
        ambients = [float(c.source["ambient"]) for c in self.channels.values() if "ambient" in c.source]
        return ambients[0] if ambients else AMBIENT

    @property
    def supply_gauge(self) -> float | None:
        """Gauge pressure of the supply, Pa: the machine's, else the median in the log if positive, else None."""
        if self.machine is not None:
            return self.machine.supply.pressure_gauge
        supply = self.find_channel("supply")
        gauge = float(np.median(supply.samples)) - self.ambient if supply is not None else 0.0
        return gauge if gauge > 0.0 else None

    def difference(self, joint: str | None) -> Array | None:
        """Return the pressure of hose A less hose B, Pa, (samples,), from both or as measured; None without either."""
        a, b = self.find_channel("pressure_a", joint), self.find_channel("pressure_b", joint)
        if a is not None and b is not None:
            return a.values - b.values
        measured = self.find_channel("measured_pressure", joint)
        return measured.values if measured is not None else None


def prepare_log(log: Dataset, description: object | None) -> CheckedLog:
    """Return the channels of a log with its attributes, and the machine if the description is one."""
    attributes = json.loads(log.attrs.get("log_columns", "{}"))
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
            if attributes and name not in attributes:
                continue  # of another joint only
            numbers = np.asarray(column.values, dtype=np.float64)
            channels[name] = Channel(name, signal, joint, numbers, attributes.get(name, {}))
    time = np.asarray(log["time"].values, dtype=np.float64)
    period = float(log.attrs.get("log_period", np.median(np.diff(time)) if time.size > 1 else 0.0))
    machine = description if isinstance(description, Machine) else None
    notes = tuple(json.loads(log.attrs.get("log_notes", "[]")))
    return CheckedLog(channels, time, period, joints, json.loads(log.attrs.get("log_clocks", "[]")), machine, notes)


def moving_average(values: Array, samples: int) -> Array:
    """Return the moving average over some samples, (size - samples + 1,)."""
    return np.convolve(values, np.full(samples, 1.0 / samples), "valid") if samples > 1 else values


def median_filter(values: Array) -> Array:
    """Return the median of every sample and its two neighbours, (samples,).

    Monotonic parts stay as they are, and single spikes go: a slipping element would take a spike for a motion to and
    fro, and forget where the motion reversed.
    """
    padded = np.concatenate([values[:1], values, values[-1:]])
    return np.asarray(np.median(np.stack([padded[:-2], padded[1:-1], padded[2:]]), axis=0))


def noise_deviation(values: Array) -> float:
    """Return the standard deviation of a slow signal's noise, by second differences; at least half a smallest step."""
    if values.size < 3:
        return 0.0
    deviation = np.median(np.abs(np.diff(values, 2))) * 1.4826 / np.sqrt(6.0)
    return float(max(deviation, smallest_step(values) / 2.0))


def smallest_step(values: Array) -> float:
    """Return the smallest step between samples, such as a converter's; 0 for none, rounding left out."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > 1e-9 * max(float(np.abs(values).max(initial=0.0)), 1e-300)]
    return float(steps.min(initial=np.inf)) if steps.size else 0.0


def find_runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return first sample and length of each run of true flags."""
    edges = np.diff(np.concatenate(([0], flags.astype(np.int8), [0])))
    firsts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return [(int(first), int(end - first)) for first, end in zip(firsts, ends, strict=True)]
