"""MCAP files: messages of ROS 2 or in JSON, flattened to columns, each with the log time of its messages."""

import json
from array import array
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from layflat import extras
from layflat.errors import InputError, LayflatError
from layflat.identify.logs.headers import Header, header_of
from layflat.identify.logs.table import Column

LARGEST = 64  # items of an array that become columns; longer ones are images and scans
CYCLE = "layflat_msgs/msg/Cycle"  # type of the messages of a rig's recorder


def read_bag(path: Path) -> tuple[dict[str, Column], Header | None]:
    """Columns "topic.field" of an MCAP file; times are seconds since the first message.

    Arrays become "topic.field.0" and so on, or go by name where `name` or `names` stands beside them, as in
    sensor_msgs/JointState. Topics in other encodings are left out. A log of `layflat rig` has our own names, without
    topics: its cycles alone are read, over their own time. Raise InputError if it is none, nothing in it can be
    decoded, or the packages are not installed.
    """
    extras.require("logs", "mcap", "mcap_ros2", where=str(path))
    samples: dict[str, tuple[list[int], list[float]]] = {}
    try:
        if _is_of_a_rig(path):
            return _rig_columns(path), Header("time", "s", None, "time")
        for topic, stamp, message in _messages(path):
            for field, value in flattened(message):
                stamps, values = samples.setdefault(f"{topic}.{field}" if field else topic, ([], []))
                stamps.append(stamp)
                values.append(value)
    except LayflatError:
        raise
    except Exception as error:  # a damaged file can make the decoders raise nearly anything
        what = " ".join(str(error).split()) or type(error).__name__
        right = "give a whole MCAP file; `layflat log repair` keeps what is whole of this one"
        raise InputError(f"can't be read as MCAP ({what})", where=str(path), right=right) from None
    if not samples:
        right = "give messages of ROS 2 (CDR) or in JSON"
        raise InputError("holds no messages with numbers", where=str(path), right=right)
    first = min(stamps[0] for stamps, _ in samples.values())
    columns = {}
    for name, (stamps, values) in samples.items():
        since = (np.array(stamps, dtype=np.int64) - first).astype(np.float64) * 1e-9
        columns[name] = Column(np.array(values, dtype=np.float64), header_of(name), since)
    return columns, Header("log_time", "s", None, "log_time")


def _is_of_a_rig(path: Path) -> bool:
    """Whether the recorder of a rig has written a file."""
    from mcap.reader import make_reader  # noqa: PLC0415

    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    return summary is not None and any(schema.name == CYCLE for schema in summary.schemas.values())


def _rig_columns(path: Path) -> dict[str, Column]:
    """Columns "voltage.large", "supply" and so on."""
    from layflat.rig.recorder.run import read_recording  # noqa: PLC0415

    log = read_recording(path)
    time = log.columns.pop("time")
    columns = {}
    for field, values in log.columns.items():
        names = [field] if values.ndim == 1 else [f"{field}.{joint}" for joint in log.joints]
        for name, column in zip(names, values.reshape(len(time), -1).T, strict=True):
            columns[name] = Column(column, Header(name, "", None, name), time)
    return columns


def _messages(path: Path) -> Iterator[tuple[str, int, Any]]:
    """Topic, log time (ns) and content of each message, in the order of their log times; None if not decoded."""
    from mcap.decoder import DecoderFactory  # noqa: PLC0415
    from mcap.reader import make_reader  # noqa: PLC0415
    from mcap_ros2.decoder import DecoderFactory as Ros2  # noqa: PLC0415

    class Others(DecoderFactory):
        def decoder_for(self, message_encoding: str, schema: Any) -> Any:  # noqa: ARG002
            return json.loads if message_encoding == "json" else lambda _: None

    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[Ros2(), Others()])
        for _, channel, message, content in reader.iter_decoded_messages():
            yield channel.topic.lstrip("/"), message.log_time, content


def flattened(message: Any, prefix: str = "") -> Iterator[tuple[str, float]]:
    """Dotted names and values of all numbers in a message; a time of seconds and nanoseconds is one number."""
    fields = _fields(message)
    if fields is None:
        if isinstance(message, (bool, int, float)):
            yield prefix, float(message)
        return
    if set(fields) == {"sec", "nanosec"}:
        yield prefix, fields["sec"] + 1e-9 * fields["nanosec"]
        return
    names: Any = fields.get("name", fields.get("names"))
    for key, value in fields.items():
        place = f"{prefix}.{key}" if prefix else key
        if not isinstance(value, (list, tuple, array)):
            yield from flattened(value, place)
        elif len(value) <= LARGEST:
            named = isinstance(names, list) and len(names) == len(value) and all(isinstance(one, str) for one in names)
            for label, item in zip(names if named else range(len(value)), value, strict=True):
                yield from flattened(item, f"{place}.{label}")


def _fields(message: Any) -> dict[str, Any] | None:
    """Fields of a message; None for what is not a message."""
    if isinstance(message, dict):
        return message
    if isinstance(message, SimpleNamespace) or hasattr(message, "__slots__"):
        slots = getattr(message, "__slots__", None) or vars(message)
        return {name: getattr(message, name) for name in slots if not name.startswith("_")}
    return None
