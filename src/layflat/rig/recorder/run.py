"""A recorded log as a run: an `xarray.Dataset` with the names, units and attributes of a simulated one."""

import json
import struct
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.rig.clock import SECOND
from layflat.rig.driver import DeviceState
from layflat.rig.recorder.bag import MACHINE, METADATA
from layflat.rig.recorder.messages import CYCLE, LOG, Fixed, meanings_in
from layflat.rig.recorder.repair import check_magic
from layflat.rig.recorder.ring import Event
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.states import State

if TYPE_CHECKING:
    import xarray
    from mcap.reader import McapReader
    from mcap.records import Message, Schema

# What a rig does not know of itself, and the signal that stands in for it.
BEST_KNOWN = {
    "angle": ("measured_angle", "rad", "joint angle, as sampled"),
    "velocity": ("averaged_velocity", "rad/s", "joint velocity, from the averaged angle"),
    "air_taken": ("estimated_air", "kg", "air taken from the supply since the start, estimated"),
}
# Columns that stand for something else than a quantity.
FLAGS: dict[str, type[IntEnum]] = {"mode": State, "fault": Fault, "joint_fault": Fault, "device": DeviceState}
RENAMED = {"far": "device"}  # columns that logs of earlier versions have, by their present names
# Faults by their numbers in logs that do not say so themselves: all but what there has been since.
FIRST_FAULTS = [fault.name for fault in Fault if fault is not Fault.MODEL_DOUBTED]
# What readers raise on bytes that make no sense.
UNREADABLE = (ValueError, struct.error, KeyError, IndexError, NotImplementedError)


@dataclass(frozen=True)
class Recording:
    """What an MCAP log of a rig holds."""

    joints: tuple[str, ...]  # names, from base to tip
    columns: dict[str, Array]  # of every cycle: (cycles,), or (cycles, joints)
    meanings: dict[str, tuple[str, str]]  # unit and meaning of each column
    events: list[Event]
    begin: int  # log time of the loop's time 0, ns since 1970
    about: dict[str, str]  # what the log says of itself
    machine: str  # description as JSON; empty where it is missing


def read_recording(path: Path) -> Recording:
    """Read a log that the recorder has written; raise InputError if it can't be read, is not whole, or none of ours."""
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


def _recording(reader: "McapReader", path: Path) -> Recording:
    from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415

    schemas: dict[str, Schema | None] = {}
    cycles: list[Message] = []
    events: list[Message] = []
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        kind = schema.name if schema is not None else channel.message_encoding
        schemas.setdefault(kind, schema)
        if kind in {CYCLE, LOG}:
            (cycles if kind == CYCLE else events).append(message)
    if not cycles:
        shown = f"only {', '.join(sorted(schemas))}" if schemas else "no messages"
        right = "give a log of `layflat rig`; `layflat log map` starts a mapping for others"
        raise InputError(f"holds no cycles of a rig, {shown}", where=str(path), right=right)

    def decoded(kind: str, messages: list["Message"]) -> list[Any]:
        decode = DecoderFactory().decoder_for("cdr", schemas[kind]) if messages else None
        return [decode(message.data) for message in messages] if decode is not None else []

    definition = schemas[CYCLE].data.decode()  # type: ignore[union-attr]  # it has a name
    joints = tuple(decoded(CYCLE, cycles[:1])[0].name)
    columns = Fixed(definition, joints).decoded(message.data for message in cycles)
    begin = cycles[0].log_time - round(float(columns["time"][0]) * SECOND)
    about = next((one.metadata for one in reader.iter_metadata() if one.name == METADATA), {})
    names, known = json.loads(about["faults"]) if "faults" in about else FIRST_FAULTS, Fault.__members__
    if names != list(known):
        numbers = np.array([known.get(name, max(Fault)) for name in names], dtype=np.float64)
        columns |= {name: numbers[columns[name].astype(int)] for name in ("fault", "joint_fault") if name in columns}
    return Recording(
        joints=joints,
        columns={RENAMED.get(name, name): values for name, values in columns.items()},
        meanings={RENAMED.get(name, name): meaning for name, meaning in meanings_in(definition).items()},
        events=[
            Event((message.log_time - begin) / SECOND, one.level, one.msg)
            for message, one in zip(events, decoded(LOG, events), strict=True)
        ],
        begin=begin,
        about=about,
        machine=next((one.data.decode() for one in reader.iter_attachments() if one.name == MACHINE), ""),
    )


def read_run(path: Path) -> "xarray.Dataset":
    """Read a log as a run.

    Dims `time` (as the loop recorded it: its cycles are not quite even, and some may be missing), `joint`, and `event`.
    A rig does not know what moves: `angle` is the measured one, `velocity` that of the averaged angle, and there are no
    pressures of single hoses. Attributes are those of a simulated run, as far as there are any, with `start`, the time
    of day, and `notes`. InputError as from `read_recording`.
    """
    import xarray  # noqa: PLC0415  # takes long to import

    log = read_recording(path)
    run = xarray.Dataset(coords={"time": ("time", log.columns["time"], {"units": "s"}), "joint": list(log.joints)})
    for name, (source, unit, meaning) in BEST_KNOWN.items():
        if source in log.columns:  # logs of earlier versions lack some
            run[name] = (("time", "joint"), log.columns[source], {"units": unit, "long_name": meaning})
    for name, values in log.columns.items():
        if name == "time":
            continue
        unit, meaning = log.meanings.get(name, ("1", name))
        about: dict[str, Any] = {"units": unit, "long_name": meaning}
        if kind := FLAGS.get(name):  # as the CF conventions tell it
            about["flag_values"] = np.array([int(flag) for flag in kind])
            about["flag_meanings"] = " ".join(flag.name.lower() for flag in kind)
        run[name] = (("time", "joint")[: values.ndim], values, about)
    run["event_time"] = ("event", np.array([e.time for e in log.events]), {"units": "s", "long_name": "of an event"})
    run["event_level"] = ("event", np.array([e.level for e in log.events], dtype=np.int64), {"units": "1"})
    run["event_text"] = ("event", np.array([e.text for e in log.events], dtype=object))
    run.attrs = {"machine": log.machine, **{k: v for k, v in log.about.items() if k not in {"joints", "faults"}}}
    return run


def check_format(path: Path) -> None:
    """Make sure that a name says how to write; raise InputError if it does not, or the package for it is missing."""
    if path.suffix not in _WRITERS:
        raise InputError(f"{path.suffix or path.name!r} is not a format", where=str(path), right="use .nc or .parquet")
    if path.suffix == ".parquet":
        extras.require("rig", "pyarrow", where=str(path))


def export(run: "xarray.Dataset", path: Path) -> Path:
    """Write a recorded run, by what the name ends in: NetCDF (.nc), or Parquet (.parquet), a column a signal.

    Raise InputError as `check_format` does, and OutputError if it can't be written there.
    """
    check_format(path)
    with whole_file(path) as temporary:
        _WRITERS[path.suffix](run, temporary)
    return path


def _write_netcdf(run: "xarray.Dataset", path: Path) -> None:
    path.write_bytes(run.to_netcdf(None, engine="h5netcdf"))  # in memory: HDF5 brings the process down on a full disk


def _write_parquet(run: "xarray.Dataset", path: Path) -> None:
    """Columns "time", "supply", "angle.large"; units stand with the fields, the rest in the file's metadata."""
    import pyarrow  # noqa: PLC0415
    from pyarrow import parquet  # noqa: PLC0415

    joints = run["joint"].to_numpy()
    columns, fields = [], []
    for name, variable in run.variables.items():
        if variable.dims[:1] != ("time",):
            continue
        names = [f"{name}.{joint}" for joint in joints] if variable.ndim == 2 else [str(name)]
        for column, values in zip(names, variable.to_numpy().reshape(run.sizes["time"], -1).T, strict=True):
            columns.append(pyarrow.array(values))
            fields.append(pyarrow.field(column, pyarrow.float64(), metadata={"unit": variable.attrs["units"]}))
    told = (run[name].to_numpy().tolist() for name in ("event_time", "event_level", "event_text"))
    about = {key: str(value) for key, value in run.attrs.items()}
    about["events"] = json.dumps(list(zip(*told, strict=True)))
    parquet.write_table(pyarrow.table(columns, schema=pyarrow.schema(fields, metadata=about)), path)


_WRITERS = {".nc": _write_netcdf, ".parquet": _write_parquet}  # by suffix
