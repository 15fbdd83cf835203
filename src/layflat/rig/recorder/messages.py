"""The messages of a log, as ROS 2 has them (CDR), so that common viewers open it.

All messages of a kind have the same size in one log, since their strings are the joints' names: a numpy type says what
stands where, and thousands are written or read at once.

| topic | type | |
|---|---|---|
| /cycle | layflat_msgs/msg/Cycle | all of a cycle's row (rig/record.py), arrays by joint |
| /joint_states | sensor_msgs/msg/JointState | angle as measured, velocity as averaged |
| /events | rcl_interfaces/msg/Log | faults, changes of state, messages |
"""

import re
import struct
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.rig.clock import SECOND
from layflat.rig.record import SHARED, Layout
from layflat.rig.recorder.ring import Event

CYCLE, JOINT_STATE, LOG = "layflat_msgs/msg/Cycle", "sensor_msgs/msg/JointState", "rcl_interfaces/msg/Log"

_RULE = "=" * 80
_TIME = f"{_RULE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
_HEADER = f"{_RULE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{_TIME}"


def _fields(kind: str, fields: dict[str, tuple[str, str]]) -> str:
    return "".join(f"{kind} {name}  # {unit}: {meaning}\n" for name, (unit, meaning) in fields.items())


_BY_NAME = "std_msgs/Header header\nstring[] name\n"


def schemas_of(layout: Layout) -> dict[str, str]:
    """Definitions by type, with what they build on."""
    cycle = f"{_BY_NAME}{_fields('float64', SHARED)}{_fields('float64[]', layout.by_joint)}{_HEADER}"
    return {CYCLE: cycle, **SCHEMAS}


# Definitions of the types that are the same in all logs.
SCHEMAS = {
    JOINT_STATE: f"{_BY_NAME}float64[] position\nfloat64[] velocity\nfloat64[] effort\n{_HEADER}",
    LOG: "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\n"
    f"string file\nstring function\nuint32 line\n{_TIME}",
}


def meanings_in(definition: str) -> dict[str, tuple[str, str]]:
    """Unit and meaning of each number of a type, as its definition tells them."""
    found = re.findall(r"^float64(?:\[\])? (\w+)  # (.*?): (.*)$", definition.partition(_RULE)[0], re.MULTILINE)
    return {name: (unit, meaning) for name, unit, meaning in found}


class Fixed:
    """Messages of one type for these joints: a header, the joints' names, numbers, and arrays by joint.

    The schema is the definition of the type; arrays named in `empty`, at its end, are left empty.
    """

    def __init__(self, schema: str, joints: Sequence[str], empty: Sequence[str] = ()) -> None:
        start = bytes((0, 1, 0, 0)) + struct.pack("<iI", 0, 0) + _string("")
        start = _aligned(start, 4) + struct.pack("<I", len(joints))
        for joint in joints:
            start = _aligned(start, 4) + _string(joint)
        self._start = slice(12, len(start))  # what tells the joints, and is the same in all messages
        names, formats, offsets = ["sec", "nanosec"], ["<i4", "<u4"], [4, 8]
        for kind, name in re.findall(r"^(float64(?:\[\])?) (\w+)", schema.partition(_RULE)[0], re.MULTILINE):
            if kind.endswith("[]"):
                count = 0 if name in empty else len(joints)
                start = _aligned(start, 4) + struct.pack("<I", count)
                if not count:
                    continue
            start = _aligned(start, 8)
            names.append(name)
            formats.append(f"({len(joints)},)<f8" if kind.endswith("[]") else "<f8")
            offsets.append(len(start))
            start += bytes(8 * (len(joints) if kind.endswith("[]") else 1))
        plain: Any = {"names": names, "formats": formats, "offsets": offsets, "itemsize": len(start)}
        self.dtype = np.dtype(plain)
        self.fields = tuple(names[2:])
        self._blank = np.frombuffer(start, np.uint8)

    def encoded(self, stamps: NDArray[np.int64], columns: dict[str, Array]) -> list[bytes]:
        """Messages as bytes, from stamps (ns since 1970, (messages,)) and columns by field, (messages[, joints])."""
        block = np.tile(self._blank, (len(stamps), 1))
        fields = block.view(self.dtype)[:, 0]
        fields["sec"], fields["nanosec"] = np.divmod(stamps, SECOND)
        for name, values in columns.items():
            fields[name] = values
        return [row.tobytes() for row in block]

    def decoded(self, messages: Iterable[bytes]) -> dict[str, Array]:
        """Columns by field, from messages as bytes; raise ValueError if they are not of this type and these joints."""
        block = np.frombuffer(b"".join(messages), np.uint8)
        rows = block.reshape(-1, self.dtype.itemsize)
        if (rows[:, self._start] != self._blank[self._start]).any():
            raise ValueError("messages of other joints")
        fields = rows.view(self.dtype)[:, 0]
        return {name: np.ascontiguousarray(fields[name]) for name in self.fields}


def encoded_event(stamp: int, event: Event) -> bytes:
    """An event as a message of type Log; `stamp` in ns since 1970."""
    data = bytes((0, 1, 0, 0)) + struct.pack("<iIB", *divmod(stamp, SECOND), event.level)
    for text in ("layflat.rig", event.text, "", ""):
        data = _aligned(data, 4) + _string(text)
    return _aligned(data, 4) + struct.pack("<I", 0)


def _string(text: str) -> bytes:
    data = text.encode() + b"\0"
    return struct.pack("<I", len(data)) + data


def _aligned(data: bytes, to: int) -> bytes:
    """With zeros up to where a number of `to` bytes may stand; positions count from behind the 4 bytes of encoding."""
    return data + bytes(-(len(data) - 4) % to)
