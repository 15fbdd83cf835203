"""Rows and events as an MCAP file with ROS 2 messages (CDR), which common viewers open.

All messages of a kind have the same size in one log, since their strings are the joints' names: a numpy type describes
their bytes, and thousands are written or read at once.

| topic | type | |
|---|---|---|
| /cycle | layflat_msgs/msg/Cycle | all of a cycle's row (rig/record.py), arrays by joint |
| /joint_states | sensor_msgs/msg/JointState | angle as measured, velocity as averaged |
| /events | rcl_interfaces/msg/Log | faults, changes of state, messages |
"""

import json
import re
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import IO, TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from layflat._version import __version__
from layflat.arrays import Array
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.record import SHARED_COLUMNS, RowLayout
from layflat.rig.recorder.ring import Event
from layflat.rig.safety.faults import Fault

if TYPE_CHECKING:
    from layflat.machine import Machine

CYCLE_TYPE, JOINT_STATE_TYPE, LOG_TYPE = (
    "layflat_msgs/msg/Cycle",
    "sensor_msgs/msg/JointState",
    "rcl_interfaces/msg/Log",
)

_SEPARATOR_LINE = "=" * 80
_TIME_DEFINITION = f"{_SEPARATOR_LINE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
_HEADER_DEFINITION = (
    f"{_SEPARATOR_LINE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{_TIME_DEFINITION}"
)
_NAMED_HEADER_FIELDS = "std_msgs/Header header\nstring[] name\n"
# Definitions of the types that are the same in all logs.
SCHEMAS = {
    JOINT_STATE_TYPE: f"{_NAMED_HEADER_FIELDS}float64[] position\nfloat64[] velocity\n"
    f"float64[] effort\n{_HEADER_DEFINITION}",
    LOG_TYPE: "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\n"
    f"string file\nstring function\nuint32 line\n{_TIME_DEFINITION}",
}
METADATA, MACHINE_ATTACHMENT = "layflat", "machine.json"  # names of the metadata, and of the machine's description
FAULT_NAMES = list(Fault.__members__)  # by the numbers that stand in rows
CHUNK_BYTES = 2**17  # bytes that are compressed at a time: compressing more would delay the log


def _field_definitions(kind: str, fields: dict[str, tuple[str, str]]) -> str:
    return "".join(f"{kind} {name}  # {unit}: {meaning}\n" for name, (unit, meaning) in fields.items())


def schema_definitions(layout: RowLayout) -> dict[str, str]:
    """Return the message definitions of a log by type, nested types included."""
    fields = _field_definitions("float64", SHARED_COLUMNS) + _field_definitions("float64[]", layout.by_joint)
    cycle = f"{_NAMED_HEADER_FIELDS}{fields}{_HEADER_DEFINITION}"
    return {CYCLE_TYPE: cycle, **SCHEMAS}


def parse_meanings(definition: str) -> dict[str, tuple[str, str]]:
    """Return unit and meaning of each number of a message type, by name, from its definition."""
    matches = re.findall(
        r"^float64(?:\[\])? (\w+)  # (.*?): (.*)$", definition.partition(_SEPARATOR_LINE)[0], re.MULTILINE
    )
    return {name: (unit, meaning) for name, unit, meaning in matches}


class MessageCodec:
    """Codec of messages of one type: a header, the joints' names, numbers, and arrays by joint.

    Args:
        schema: definition of the type.
        joints: names of the joints.
        empty: names of arrays at the end of the type that are left empty.
    """

    def __init__(self, schema: str, joints: Sequence[str], empty: Sequence[str] = ()) -> None:
        start = bytes((0, 1, 0, 0)) + struct.pack("<iI", 0, 0) + _encode_string("")
        start = _pad_to_alignment(start, 4) + struct.pack("<I", len(joints))
        for joint in joints:
            start = _pad_to_alignment(start, 4) + _encode_string(joint)
        self._start = slice(12, len(start))  # bytes with the joints' names, the same in all messages
        names, formats, offsets = ["sec", "nanosec"], ["<i4", "<u4"], [4, 8]
        for kind, name in re.findall(r"^(float64(?:\[\])?) (\w+)", schema.partition(_SEPARATOR_LINE)[0], re.MULTILINE):
            if kind.endswith("[]"):
                count = 0 if name in empty else len(joints)
                start = _pad_to_alignment(start, 4) + struct.pack("<I", count)
                if not count:
                    continue
            start = _pad_to_alignment(start, 8)
            names.append(name)
            formats.append(f"({len(joints)},)<f8" if kind.endswith("[]") else "<f8")
            offsets.append(len(start))
            start += bytes(8 * (len(joints) if kind.endswith("[]") else 1))
        plain: Any = {"names": names, "formats": formats, "offsets": offsets, "itemsize": len(start)}
        self.dtype = np.dtype(plain)
        self.fields = tuple(names[2:])
        self._blank = np.frombuffer(start, np.uint8)

    def encode(self, stamps: NDArray[np.int64], columns: dict[str, Array]) -> list[bytes]:
        """Return messages from stamps (ns since 1970, (messages,)) and columns by field, (messages[, joints])."""
        block = np.tile(self._blank, (len(stamps), 1))
        fields = block.view(self.dtype)[:, 0]
        fields["sec"], fields["nanosec"] = np.divmod(stamps, NS_PER_SECOND)
        for name, values in columns.items():
            fields[name] = values
        return [row.tobytes() for row in block]

    def decode(self, messages: Iterable[bytes]) -> dict[str, Array]:
        """Return columns by field from messages; raise ValueError if they are not of this type and these joints."""
        block = np.frombuffer(b"".join(messages), np.uint8)
        rows = block.reshape(-1, self.dtype.itemsize)
        if (rows[:, self._start] != self._blank[self._start]).any():
            raise ValueError("messages of other joints")
        fields = rows.view(self.dtype)[:, 0]
        return {name: np.ascontiguousarray(fields[name]) for name in self.fields}


def encode_event(stamp: int, event: Event) -> bytes:
    """Return an event as a message of type Log; `stamp` in ns since 1970 replaces the event's own time."""
    data = bytes((0, 1, 0, 0)) + struct.pack("<iIB", *divmod(stamp, NS_PER_SECOND), event.level)
    for text in ("layflat.rig", event.text, "", ""):
        data = _pad_to_alignment(data, 4) + _encode_string(text)
    return _pad_to_alignment(data, 4) + struct.pack("<I", 0)


def _encode_string(text: str) -> bytes:
    """Return a CDR string: its length in bytes, the closing zero counted, and the text in UTF-8 with that zero."""
    data = text.encode() + b"\0"
    return struct.pack("<I", len(data)) + data


def _pad_to_alignment(data: bytes, to: int) -> bytes:
    """Return data padded with zeros to a multiple of `to` bytes, the 4 bytes of the encoding header not counted."""
    return data + bytes(-(len(data) - 4) % to)


@dataclass(frozen=True)
class LogHeading:
    """Heading of a log: the layout of its rows, and its metadata."""

    layout: RowLayout
    machine: str  # description as JSON
    machine_name: str
    notes: dict[str, str] = field(default_factory=dict)  # further metadata, such as the driver's address

    @classmethod
    def for_machine(cls, machine: "Machine", **notes: str) -> Self:
        """Return the heading of a machine's log; `notes` are further metadata by name."""
        return cls(RowLayout.for_machine(machine), machine.model_dump_json(), machine.name, notes)


class BagWriter:
    """Writer of an MCAP file.

    Log times are the time of day at which the loop began, plus the loop's own time: they never jump.

    Args:
        stream: file that is open for writing bytes.
        heading: heading of the log.
        begin: time of day at which the loop began, ns since 1970.
        chunked: whether to write compressed chunks with an index; else each record is written at once.
    """

    def __init__(self, stream: IO[bytes] | Any, heading: LogHeading, begin: int, *, chunked: bool) -> None:
        from mcap.writer import Writer  # noqa: PLC0415

        self.begin = begin
        self._layout = layout = heading.layout
        schemas = schema_definitions(layout)
        self._cycles = MessageCodec(schemas[CYCLE_TYPE], layout.joints)
        self._states = MessageCodec(schemas[JOINT_STATE_TYPE], layout.joints, empty=("effort",))
        self._writer = Writer(stream, CHUNK_BYTES, use_chunking=chunked)
        self._writer.start("ros2", f"layflat {__version__}")
        self._cycle, self._state, self._events = (
            self._writer.register_channel(
                topic, "cdr", self._writer.register_schema(kind, "ros2msg", schemas[kind].encode())
            )
            for topic, kind in (("/cycle", CYCLE_TYPE), ("/joint_states", JOINT_STATE_TYPE), ("/events", LOG_TYPE))
        )
        start = datetime.fromtimestamp(begin / NS_PER_SECOND, UTC).isoformat()
        about = {"layflat_version": __version__, "machine_name": heading.machine_name, "start": start}
        metadata = {**about, "joints": json.dumps(layout.joints), "notes": json.dumps(heading.notes)}
        metadata["faults"] = json.dumps(FAULT_NAMES)
        self._writer.add_metadata(METADATA, metadata)
        self._writer.add_attachment(begin, begin, MACHINE_ATTACHMENT, "application/json", heading.machine.encode())

    def add(self, rows: Array) -> None:
        """Add rows, (rows, width), each as a message on /cycle and one on /joint_states."""
        if not len(rows):
            return
        columns = {name: self._layout.named(rows, name) for name in (*SHARED_COLUMNS, *self._layout.by_joint)}
        stamps = self.begin + np.rint(columns["time"] * NS_PER_SECOND).astype(np.int64)
        cycles = self._cycles.encode(stamps, columns)
        motion = {"position": columns["measured_angle"], "velocity": columns["averaged_velocity"]}
        states = self._states.encode(stamps, motion)
        for stamp, cycle, state in zip(stamps.tolist(), cycles, states, strict=True):
            self._writer.add_message(self._cycle, stamp, cycle, stamp)
            self._writer.add_message(self._state, stamp, state, stamp)

    def write_event(self, event: Event) -> None:
        """Add an event as a message on /events."""
        stamp = self.begin + round(event.time * NS_PER_SECOND)
        self._writer.add_message(self._events, stamp, encode_event(stamp, event), stamp)

    def finish(self) -> None:
        """Write the summary and the end; the stream stays open."""
        self._writer.finish()
