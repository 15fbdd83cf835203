"""Episodes of logs: what a log's sensors measured, and the command at the same instants, at an even rate."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array, Dataset
from layflat.description.wrong import did_you_mean
from layflat.errors import InputError
from layflat.identify.logs.arrays import list_dataset
from layflat.identify.logs.formats import read_table
from layflat.identify.logs.mapping import LogMapping, map_own_names, read_mapping
from layflat.identify.logs.read import read_log
from layflat.identify.logs.table import LogTable
from layflat.identify.logs.vocabulary import SIGNALS, channel_name
from layflat.lerobot import VectorFeature
from layflat.lerobot.writer import check_fps

LogSource: TypeAlias = "str | Path | LogTable | Dataset | Callable[[], LogTable]"
"""File of a log, its table, its data set, or a function that reads it."""

STATE_SIGNALS = ("angle", "pressure_a", "pressure_b", "measured_pressure")
"""Signals of the sensors, of which a log has the angle and any pressures."""

ACTION_SIGNALS = ("demand", "voltage")  # signals that command a joint
EPISODE_SPLITS = ("log", "move")  # what makes an episode
RATE_TOLERANCE = 0.01  # by which a rate may exceed that of a log whose clock is not quite even
EVEN_RATE = 1e-9  # relative deviation of a log's rate from a whole number that is rounding
MIN_EPISODE = 2  # frames


@dataclass(frozen=True)
class EpisodeFrames:
    """Frames of a log, at an even rate: rows where all signals have values, and the episodes among them."""

    name: str  # of the log
    fps: int
    state: VectorFeature
    action: VectorFeature
    state_rows: Array  # (frames, components)
    action_rows: Array
    spans: tuple[tuple[int, int], ...]  # first row of each episode, and the row behind its last

    def episodes(self) -> Iterator[dict[str, Array]]:
        """Yield the rows of each episode, by feature."""
        for first, end in self.spans:
            yield {"observation.state": self.state_rows[first:end], "action": self.action_rows[first:end]}

    @property
    def left_out(self) -> int:
        """Count of rows in no episode: signals are missing there, or no move has begun."""
        return len(self.state_rows) - sum(end - first for first, end in self.spans)


def read_episodes(
    source: LogSource,
    *,
    fps: int | None,
    action: Literal["demand", "voltage"],
    split: Literal["log", "move"],
    mapping: LogMapping | str | Path | None,
    joints: Sequence[str] | None,
) -> EpisodeFrames:
    """Read a log as episodes.

    Args:
        source: the log.
        fps: frames a second, up to the log's own rate; None: that rate.
        action: signal that is the action.
        split: "log" for an episode a log, cut where a signal has a gap; "move" for one from each move of the demand
            to the next.
        mapping: mapping of the columns, or its file; not needed where they have layflat's own names.
        joints: joints of the machine, in its order.

    Raises:
        InputError: the log can't be read, lacks a signal, or has no such rate.
    """
    table = _load_table(source)
    used = {*STATE_SIGNALS, action} | ({"demand"} if split == "move" else set())
    plan = read_mapping(mapping) if isinstance(mapping, (str, Path)) else mapping or map_own_names(table)
    mapped = [] if plan is None else list(dict.fromkeys(entry.signal for entry in plan.column))
    if plan is not None and not used.isdisjoint(mapped):
        plan = plan.model_copy(update={"column": tuple(entry for entry in plan.column if entry.signal in used)})
    cycle = 1.0 / check_fps(fps) if fps is not None else None
    log = read_log(table, plan, joints=joints, cycle=cycle)
    name = str(table.path)
    rate = fps if fps is not None else _own_rate(log, name)
    _check_rate(log, rate, name)
    if fps is None and abs(rate * log.attrs["log_period"] - 1.0) > EVEN_RATE:
        log = read_log(table, plan, joints=joints, cycle=1.0 / rate)
    missing = [signal for signal in ("angle", *sorted(used - set(STATE_SIGNALS))) if signal not in log]
    if missing:
        raise _missing_error(missing[0], mapped, action, name)
    state, state_rows = _stack_signals(log, [signal for signal in STATE_SIGNALS if signal in log], name)
    command, command_rows = _stack_signals(log, [action], name)
    valid = np.isfinite(state_rows).all(axis=1) & np.isfinite(command_rows).all(axis=1)
    spans = _find_runs(np.asarray(valid))
    if split == "move":
        demand = command_rows if action == "demand" else _stack_signals(log, ["demand"], name)[1]
        spans = _split_at_moves(spans, demand)
    spans = [(first, end) for first, end in spans if end - first >= MIN_EPISODE]
    if not spans:
        what = (
            f"has no {MIN_EPISODE} instants in a row at which {', '.join((*state.names, *command.names))} have values"
        )
        raise InputError(what, where=name, right="give a log, or a mapping of columns, in which they overlap")
    return EpisodeFrames(name, rate, state, command, state_rows, command_rows, tuple(spans))


def _load_table(source: LogSource) -> LogTable:
    """Return the table of a log."""
    if isinstance(source, LogTable):
        return source
    if isinstance(source, (str, Path)):
        return read_table(source)
    if callable(source):
        return source()
    name = source.attrs.get("log_name") or source.attrs.get("machine_name") or "log"
    if "time" not in source.coords:
        raise InputError("has no time", where=str(name), right='give a run or log over the dimension "time"')
    columns, clock, words, notes = list_dataset(source)
    return LogTable(Path(str(name)), "", columns, clock, notes, dict(words))


def _own_rate(log: Dataset, name: str) -> int:
    """Return the rate of a log's finest clock, Hz; raise InputError unless it is near a whole number."""
    rate = 1.0 / float(log.attrs["log_period"])
    if round(rate) < 1 or abs(rate / round(rate) - 1.0) > RATE_TOLERANCE:
        right = "give `fps`, a whole number of frames a second"
        raise InputError(f"has {rate:.4g} samples a second, and LeRobot's rates are whole", where=name, right=right)
    return check_fps(round(rate))


def _check_rate(log: Dataset, fps: int, name: str) -> None:
    """Raise InputError for a rate above that of a log's finest clock."""
    rate = 1.0 / min(clock["period"] for clock in json.loads(log.attrs["log_clocks"]) if clock["period"] > 0.0)
    if fps > rate * (1.0 + RATE_TOLERANCE):
        what = f"{fps} frames a second are more than the {rate:.4g} samples a second of {name}"
        raise InputError(what, where="fps", right=f"give {max(int(rate), 1)} or less")


def _missing_error(signal: str, mapped: Sequence[str], action: str, name: str) -> InputError:
    """Return the error for a signal that a log lacks, with those that its columns are mapped to."""
    other = next(each for each in ACTION_SIGNALS if each != action)
    right = f"map a column to {signal}"
    if signal == action and other in mapped:
        right = f"give `action={other!r}`, or {right}"
    return InputError(f"has no {signal}, only {', '.join(mapped)}", where=name, right=right)


def _stack_signals(log: Dataset, signals: Sequence[str], name: str) -> tuple[VectorFeature, Array]:
    """Return the feature of signals, joint by joint, and its rows; raise InputError for one without any value."""
    names: list[str] = []
    columns: list[Array] = []
    for signal in signals:
        joints = [str(joint) for joint in log["joint"].values] if "joint" in log[signal].dims else [None]
        names += [channel_name(signal, joint) for joint in joints]
        columns += list(log[signal].to_numpy().reshape(log.sizes["time"], -1).T)
    units = [SIGNALS[each.partition(".")[0]].unit for each in names]
    empty = [each for each, values in zip(names, columns, strict=True) if not np.isfinite(values).any()]
    if empty:
        right = f"map a column to it, or leave that joint out: {did_you_mean(empty[0], names)}"
        raise InputError(f"has no {empty[0]}", where=name, right=right)
    return VectorFeature(tuple(names), tuple(units)), np.stack(columns, axis=1)


def _find_runs(valid: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first row of each run of valid rows, and the row behind its last."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], valid, [False])).astype(np.int8)))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]


def _split_at_moves(spans: Sequence[tuple[int, int]], demand: Array) -> list[tuple[int, int]]:
    """Return the spans of moves: from the row in which a stationary demand begins to change to the next such row.

    Args:
        spans: spans of rows without gaps.
        demand: demanded angles, (rows, joints).
    """
    moves = []
    for first, end in spans:
        changes = np.any(np.diff(demand[first:end], axis=0) != 0.0, axis=1)
        starts = first + 1 + np.flatnonzero(changes & ~np.concatenate(([False], changes[:-1])))
        bounds = [*starts.tolist(), end] if starts.size else [first, end]
        moves += list(pairwise(bounds))
    return moves
