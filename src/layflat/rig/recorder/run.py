"""A recorded log as a run: an `xarray.Dataset` with the names, units and attributes of a simulated one."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from layflat import extras
from layflat.errors import InputError
from layflat.rig.clock import SECOND
from layflat.rig.driver import DeviceState
from layflat.rig.recorder.bag import MACHINE, METADATA
from layflat.rig.recorder.messages import CYCLE, LOG, Fixed, meanings_in
from layflat.rig.recorder.ring import Event
from layflat.rig.recorder.scan import check_magic
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.states import State

if TYPE_CHECKING:
    import xarray
    from mcap.reader import McapReader

BEST_KNOWN = {
    "angle": ("measured_angle", "rad", "joint angle, as sampled"),
    "velocity": ("averaged_velocity", "rad/s", "joint velocity, from the averaged angle"),
}
"""What a rig does not know of itself, and the signal that stands in for it."""

FLAGS: dict[str, type[IntEnum]] = {"mode": State, "fault": Fault, "joint_fault": Fault, "device": DeviceState}
"""Columns that stand for something else than a quantity."""

RENAMED = {"far": "device"}
"""Columns that logs of earlier versions have, by their present names."""

UNREADABLE = (ValueError, struct.error, KeyError, IndexError, NotImplementedError)
"""What readers raise on bytes that make no sense."""


@dataclass(frozen=True)
class Recording:
    """What an MCAP log of a rig holds.

    Attributes:
        joints: names, from base to tip.
        columns: of every cycle: (cycles,), or (cycles, joints).
        meanings: unit and meaning of each column.
        events: in their order.
        begin: log time of the loop's time 0, ns since 1970.
        about: what the log says of itself.
        machine: description as JSON; empty where it is missing.
    """

    joints: tuple[str, ...]
    columns: dict[str, NDArray[np.float64]]
    meanings: dict[str, tuple[str, str]]
    events: list[Event]
    begin: int
    about: dict[str, str]
    machine: str


def read_recording(path: Path) -> Recording:
    """Read a log that the recorder has written.

    Raises:
        InputError: it can't be read, is not whole, or none of ours.
    """
    extras.require("rig", "mcap", where=str(path))
    from mcap.exceptions import McapError  # noqa: PLC0415
    from mcap.reader import make_reader  # noqa: PLC0415
    from zstandard import ZstdError  # noqa: PLC0415

    if not check_magic(path):
        right = f"`layflat log repair {path}` makes it whole"
        raise InputError("was not finished", where=str(path), right=right)
    try:
        with path.open("rb") as file:
            return _recording(make_reader(file, validate_crcs=True), path)
    except (McapError, ZstdError, *UNREADABLE) as error:
        what = " ".join(str(error).split()) or type(error).__name__
        right = f"`layflat log repair {path}` keeps what is whole"
        raise InputError(f"can't be read ({what})", where=str(path), right=right) from None


def _recording(reader: McapReader, path: Path) -> Recording:
    from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415

    cycles: list[bytes] = []
    events: list[tuple[int, Any]] = []
    kinds, definition, first = set(), "", 0
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        kind = schema.name if schema is not None else channel.message_encoding
        kinds.add(kind)
        if schema is not None and kind == CYCLE:
            if not cycles:
                definition, first = schema.data.decode(), message.log_time
            cycles.append(message.data)
        elif kind == LOG:
            decode = DecoderFactory().decoder_for("cdr", schema)
            if decode is not None:
                events.append((message.log_time, decode(message.data)))
    if not cycles:
        shown = f"only {', '.join(sorted(kinds))}" if kinds else "no messages"
        right = "give a log of `layflat rig`; `layflat log map` starts a mapping for others"
        raise InputError(f"holds no cycles of a rig, {shown}", where=str(path), right=right)
    joints = _joints_of(definition, cycles[0])
    columns = {RENAMED.get(name, name): values for name, values in Fixed(definition, joints).decoded(cycles).items()}
    meanings = {RENAMED.get(name, name): meaning for name, meaning in meanings_in(definition).items()}
    begin = first - round(float(columns["time"][0]) * SECOND)
    told = [Event((stamp - begin) / SECOND, one.level, one.msg) for stamp, one in events]
    about = next((one.metadata for one in reader.iter_metadata() if one.name == METADATA), {})
    machine = next((one.data.decode() for one in reader.iter_attachments() if one.name == MACHINE), "")
    return Recording(joints, columns, meanings, told, begin, about, machine)


def _joints_of(definition: str, message: bytes) -> tuple[str, ...]:
    """The joints' names, by the first cycle."""
    from mcap.records import Schema  # noqa: PLC0415
    from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415

    decode = DecoderFactory().decoder_for("cdr", Schema(1, definition.encode(), "ros2msg", CYCLE))
    assert decode is not None
    return tuple(decode(message).name)


def _flags(name: str) -> dict[str, Any]:
    """What the numbers of a column stand for, as the CF conventions tell it."""
    kind = FLAGS.get(name)
    if kind is None:
        return {}
    return {
        "flag_values": np.array([int(flag) for flag in kind]),
        "flag_meanings": " ".join(flag.name.lower() for flag in kind),
    }


def read_run(path: Path) -> xarray.Dataset:
    """Read a log as a run.

    Dims `time` (as the loop recorded it: its cycles are not quite even, and some may be missing), `joint`, and `event`.
    A rig does not know what moves: `angle` is the measured one, `velocity` that of the averaged angle, and there are no
    pressures of single hoses. Attributes are those of a simulated run, as far as there are any, with `start`, the time
    of day, and `notes`.

    Raises:
        InputError: it can't be read, is not whole, or none of ours.
    """
    import xarray  # noqa: PLC0415  # takes long to import

    log = read_recording(path)
    run = xarray.Dataset(coords={"time": ("time", log.columns["time"], {"units": "s"}), "joint": list(log.joints)})
    for name, (source, unit, meaning) in BEST_KNOWN.items():
        run[name] = (("time", "joint"), log.columns[source], {"units": unit, "long_name": meaning})
    for name, values in log.columns.items():
        if name == "time":
            continue
        unit, meaning = log.meanings.get(name, ("1", name))
        run[name] = (("time", "joint")[: values.ndim], values, {"units": unit, "long_name": meaning, **_flags(name)})
    run["event_time"] = ("event", np.array([e.time for e in log.events]), {"units": "s", "long_name": "of an event"})
    run["event_level"] = ("event", np.array([e.level for e in log.events], dtype=np.int64), {"units": "1"})
    run["event_text"] = ("event", np.array([e.text for e in log.events], dtype=object))
    run.attrs = {"machine": log.machine, **{k: v for k, v in log.about.items() if k != "joints"}}
    return run
