"""Signals of a run or log as arrays over time stamps, from a data set with the names of a simulated run."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array, Dataset
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.machine.model import restore

NS_PER_SECOND = 1_000_000_000  # ns
EVENT_VARIABLES = ("event_time", "event_level", "event_text")


@dataclass(frozen=True)
class SignalLog:
    """Signals of joints and of the whole machine over time, with events."""

    name: str  # for people
    stamps: NDArray[np.int64]  # of the rows, ns, increasing, (n,)
    joints: tuple[str, ...]  # from base to tip
    signals: Mapping[str, Array]  # (n,), (n, joints), or (n, others) by the names of `parts`
    meanings: Mapping[str, tuple[str, str]]  # unit and meaning of each signal
    parts: Mapping[str, tuple[str, ...]]  # names along the second dimension of signals that are not by joint
    events: list[tuple[int, int, str]]  # stamp (ns), level as of rcl_interfaces/msg/Log, text
    machine: Machine | None  # whose arm is shown

    def is_by_joint(self, name: str) -> bool:
        """Return whether a signal has a value for each joint."""
        return self.signals[name].ndim == 2 and name not in self.parts

    def row(self, index: int) -> dict[str, Any]:
        """Return the signals of one row, by name."""
        return {name: values[index] for name, values in self.signals.items()}


def read_signals(data: Dataset, machine: str | Path | Machine | None = None) -> SignalLog:
    """Return the signals of a data set.

    Stamps are times of day where the data set states its start, else times since its beginning.

    Args:
        data: run of `rollout`, `open_run` or a rig, or log of `read_log`.
        machine: machine whose arm is shown; default: the one in the data set; none for a log that has none.

    Raises:
        InputError: the data set holds no numbers over time, or has other joints than the machine.
    """
    data = data.transpose("time", ...) if "time" in data.dims else data
    signals = {
        str(name): variable
        for name, variable in data.data_vars.items()
        if variable.dims[:1] == ("time",) and variable.ndim <= 2 and np.issubdtype(variable.dtype, np.number)
    }
    if "time" not in data.coords or not data.sizes["time"] or not signals:
        right = "give a run of `rollout`, or a log of a rig or a test bench"
        raise InputError("has no signals over time", where=_name_of(data), right=right)
    joints = tuple(str(name) for name in data["joint"].to_numpy()) if "joint" in data.coords else ()
    by_dimension = {
        name: tuple(str(part) for part in data[variable.dims[1]].to_numpy())
        for name, variable in signals.items()
        if variable.ndim == 2 and variable.dims[1] != "joint"
    }
    time = data["time"].to_numpy().astype(float)
    start = _start(data)
    events = []
    if all(name in data for name in EVENT_VARIABLES):
        columns = (data[name].to_numpy() for name in EVENT_VARIABLES)
        events = [(start + _stamp(t), int(level), str(text)) for t, level, text in zip(*columns, strict=True)]
    return SignalLog(
        name=_name_of(data),
        stamps=start + np.rint(time * NS_PER_SECOND).astype(np.int64),
        joints=joints,
        signals={name: variable.to_numpy() for name, variable in signals.items()},
        meanings={
            name: (str(variable.attrs.get("units", "1")), str(variable.attrs.get("long_name", name)))
            for name, variable in signals.items()
        },
        parts=by_dimension,
        events=events,
        machine=_shown_machine(data, joints, machine),
    )


def _name_of(data: Dataset) -> str:
    return str(data.attrs.get("machine_name") or data.attrs.get("log_name") or "data set")


def _stamp(seconds: float) -> int:
    return round(float(seconds) * NS_PER_SECOND)


def _start(data: Dataset) -> int:
    """Return the stamp of a data set's time 0, ns: since 1970 where it states a time of day; no stamp is below 0."""
    text = data.attrs.get("start")
    if isinstance(text, str):
        try:
            return round(datetime.fromisoformat(text).timestamp() * NS_PER_SECOND)
        except ValueError:
            pass  # the text of another program
    earliest = min([float(data["time"].min()), *map(float, data.get("event_time", []))])
    return max(_stamp(float(data.attrs.get("log_start", 0.0))), _stamp(-earliest), 0)


def _shown_machine(data: Dataset, joints: tuple[str, ...], machine: str | Path | Machine | None) -> Machine | None:
    """Return the machine whose arm is shown; None if there is none.

    Raises:
        InputError: the machine has other joints than the data set.
    """
    recorded = data.attrs.get("machine")
    shown = load(machine) if machine is not None else restore(recorded) if recorded else None
    if shown is not None and joints != tuple(shown.joints):
        has = f"has the joints {', '.join(joints)}" if joints else "names no joints"
        right = f"give one of the joints {', '.join(shown.joints)}, or another `machine`"
        raise InputError(has, where=_name_of(data), right=right)
    return shown
