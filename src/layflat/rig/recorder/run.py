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
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.device_state import DeviceState
from layflat.rig.recorder.bag import CYCLE_TYPE, LOG_TYPE, MACHINE_ATTACHMENT, METADATA, MessageCodec, parse_meanings
from layflat.rig.recorder.repair import check_magic
from layflat.rig.recorder.ring import Event
from layflat.rig.safety.faults import Fault, RigState

if TYPE_CHECKING:
    import xarray
    from mcap.reader import McapReader
    from mcap.records import Message, Schema

__all__ = ["check_format", "export_run", "read_recording", "read_run"]

# Signals that a rig does not measure: by name the recorded signal in its place, with unit and meaning.
SUBSTITUTE_SIGNALS = {
    "angle": ("measured_angle", "rad", "joint angle, as sampled"),
    "velocity": ("averaged_velocity", "rad/s", "joint velocity, from the averaged angle"),
    "air_taken": ("estimated_air", "kg", "air taken from the supply since the start, estimated"),
}
# Columns whose numbers are those of an enumeration.
FLAG_ENUMS: dict[str, type[IntEnum]] = {"mode": RigState, "fault": Fault, "joint_fault": Fault, "device": DeviceState}
COLUMN_RENAMES = {"far": "device"}  # present names of the columns of earlier versions' logs
# Names of faults by their numbers in logs without that metadata: all but those added since.
FIRST_FAULTS = [fault.name for fault in Fault if fault is not Fault.MODEL_DOUBTED]
# Errors that readers raise on invalid bytes.
DECODE_ERRORS = (ValueError, struct.error, KeyError, IndexError, NotImplementedError)


class ForeignLogError(InputError):
    """MCAP file that holds no cycles of a rig."""


@dataclass(frozen=True)
class Recording:
    """Content of an MCAP log of a rig."""

    joints: tuple[str, ...]  # names, from base to tip
    columns: dict[str, Array]  # of every cycle: (cycles,), or (cycles, joints)
    meanings: dict[str, tuple[str, str]]  # unit and meaning of each column
    events: list[Event]
    begin: int  # log time of the loop's time 0, ns since 1970
    about: dict[str, str]  # metadata
    machine: str  # description as JSON; empty where it is missing


def read_recording(path: Path) -> Recording:
    """Read a log of the recorder.

    Raises:
        ForeignLogError: it is no log of a rig.
        InputError: it can't be read, or is not whole.
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
            return _decode_recording(make_reader(file, validate_crcs=True), path)
    except (McapError, ZstdError, *DECODE_ERRORS) as error:
        what = " ".join(str(error).split()) or type(error).__name__
        right = f"`layflat log repair {path}` keeps what is whole"
        raise InputError(f"can't be read ({what})", where=str(path), right=right) from None


def _decode_recording(reader: "McapReader", path: Path) -> Recording:
    """Return the recording in an MCAP log, with names and fault numbers of older versions replaced.

    Raises:
        ForeignLogError: it holds no cycles of a rig.
    """
    from mcap_ros2.decoder import DecoderFactory  # noqa: PLC0415

    schemas: dict[str, Schema | None] = {}
    cycles: list[Message] = []
    events: list[Message] = []
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        kind = schema.name if schema is not None else channel.message_encoding
        schemas.setdefault(kind, schema)
        if kind in {CYCLE_TYPE, LOG_TYPE}:
            (cycles if kind == CYCLE_TYPE else events).append(message)
    if not cycles:
        shown = f"only {', '.join(sorted(schemas))}" if schemas else "no messages"
        right = "give a log of `layflat rig`; `layflat log map` starts a mapping for others"
        raise ForeignLogError(f"holds no cycles of a rig, {shown}", where=str(path), right=right)

    def decoded(kind: str, messages: list["Message"]) -> list[Any]:
        decode = DecoderFactory().decoder_for("cdr", schemas[kind]) if messages else None
        return [decode(message.data) for message in messages] if decode is not None else []

    definition = schemas[CYCLE_TYPE].data.decode()  # type: ignore[union-attr]  # it has a name
    joints = tuple(decoded(CYCLE_TYPE, cycles[:1])[0].name)
    columns = MessageCodec(definition, joints).decode(message.data for message in cycles)
    begin = cycles[0].log_time - round(float(columns["time"][0]) * NS_PER_SECOND)
    about = next((one.metadata for one in reader.iter_metadata() if one.name == METADATA), {})
    names, known = json.loads(about["faults"]) if "faults" in about else FIRST_FAULTS, Fault.__members__
    if names != list(known):
        numbers = np.array([known.get(name, max(Fault)) for name in names], dtype=np.float64)
        columns |= {name: numbers[columns[name].astype(int)] for name in ("fault", "joint_fault") if name in columns}
    return Recording(
        joints=joints,
        columns={COLUMN_RENAMES.get(name, name): values for name, values in columns.items()},
        meanings={COLUMN_RENAMES.get(name, name): meaning for name, meaning in parse_meanings(definition).items()},
        events=[
            Event((message.log_time - begin) / NS_PER_SECOND, one.level, one.msg)
            for message, one in zip(events, decoded(LOG_TYPE, events), strict=True)
        ],
        begin=begin,
        about=about,
        machine=next((one.data.decode() for one in reader.iter_attachments() if one.name == MACHINE_ATTACHMENT), ""),
    )


def read_run(path: Path) -> "xarray.Dataset":
    """Read a log as a run.

    Dims are `time` (as recorded: cycles are not quite even, and some may be missing), `joint`, and `event`. A rig does
    not measure all that a simulation knows: `angle` is the measured one, `velocity` that of the averaged angle, and
    there are no pressures of single hoses. Attributes are those of a simulated run, where they apply, with `start`, the
    time of day, and `notes`.

    Raises:
        InputError: as from `read_recording`.
    """
    import xarray  # noqa: PLC0415  # takes long to import

    log = read_recording(path)
    run = xarray.Dataset(coords={"time": ("time", log.columns["time"], {"units": "s"}), "joint": list(log.joints)})
    for name, (source, unit, meaning) in SUBSTITUTE_SIGNALS.items():
        if source in log.columns:  # logs of earlier versions lack some
            run[name] = (("time", "joint"), log.columns[source], {"units": unit, "long_name": meaning})
    for name, values in log.columns.items():
        if name == "time":
            continue
        unit, meaning = log.meanings.get(name, ("1", name))
        about: dict[str, Any] = {"units": unit, "long_name": meaning}
        if kind := FLAG_ENUMS.get(name):  # as the CF conventions tell it
            about["flag_values"] = np.array([int(flag) for flag in kind])
            about["flag_meanings"] = " ".join(flag.name.lower() for flag in kind)
        run[name] = (("time", "joint")[: values.ndim], values, about)
    run["event_time"] = ("event", np.array([e.time for e in log.events]), {"units": "s", "long_name": "of an event"})
    run["event_level"] = ("event", np.array([e.level for e in log.events], dtype=np.int64), {"units": "1"})
    run["event_text"] = ("event", np.array([e.text for e in log.events], dtype=object))
    run.attrs = {"machine": log.machine, **{k: v for k, v in log.about.items() if k not in {"joints", "faults"}}}
    return run


def check_format(path: Path) -> None:
    """Check that a file's suffix names a format; raise InputError if it does not, or the package for it is missing."""
    if path.suffix not in _FORMAT_WRITERS:
        raise InputError(f"{path.suffix or path.name!r} is not a format", where=str(path), right="use .nc or .parquet")
    if path.suffix == ".parquet":
        extras.require("rig", "pyarrow", where=str(path))


def export_run(run: "xarray.Dataset", path: Path) -> Path:
    """Write a recorded run in the format of the file's suffix: NetCDF (.nc), or Parquet (.parquet), a column a signal.

    Raises:
        InputError: as from `check_format`.
        OutputError: the file can't be written.
    """
    check_format(path)
    with whole_file(path) as temporary:
        _FORMAT_WRITERS[path.suffix](run, temporary)
    return path


def _write_netcdf(run: "xarray.Dataset", path: Path) -> None:
    path.write_bytes(run.to_netcdf(None, engine="h5netcdf"))  # in memory: HDF5 brings the process down on a full disk


def _write_parquet(run: "xarray.Dataset", path: Path) -> None:
    """Write columns such as "time", "angle.large", units with the fields, all else in the file's metadata."""
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
    events = (run[name].to_numpy().tolist() for name in ("event_time", "event_level", "event_text"))
    about = {key: str(value) for key, value in run.attrs.items()}
    about["events"] = json.dumps(list(zip(*events, strict=True)))
    parquet.write_table(pyarrow.table(columns, schema=pyarrow.schema(fields, metadata=about)), path)


_FORMAT_WRITERS = {".nc": _write_netcdf, ".parquet": _write_parquet}  # by suffix
