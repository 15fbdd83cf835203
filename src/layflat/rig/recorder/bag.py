"""Rows and events as an MCAP file."""

import json
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import IO, TYPE_CHECKING, Any, Self

import numpy as np

from layflat._version import __version__
from layflat.arrays import Array
from layflat.rig.clock import SECOND
from layflat.rig.record import SHARED, Layout
from layflat.rig.recorder.messages import CYCLE, JOINT_STATE, LOG, Fixed, encoded_event, schemas_of
from layflat.rig.recorder.ring import Event
from layflat.rig.safety.faults import Fault

if TYPE_CHECKING:
    from layflat.machine import Machine

METADATA, MACHINE = "layflat", "machine.json"  # names of the metadata, and of the attachment that describes the machine
FAULTS = list(Fault.__members__)  # names by the numbers that stand in rows
CHUNK = 2**17  # bytes that are compressed at a time: more would keep the recorder from its log


@dataclass(frozen=True)
class Heading:
    """Heading of a log."""

    layout: Layout
    machine: str  # description as JSON
    machine_name: str
    notes: dict[str, str] = field(default_factory=dict)  # what else is to be kept, such as the driver's address

    @classmethod
    def of(cls, machine: "Machine", **notes: str) -> Self:
        """Heading for a machine."""
        return cls(Layout.of(machine), machine.model_dump_json(), machine.name, notes)


class Bag:
    """An MCAP file that is being written.

    Log times are the time of day at which the loop began (`begin`, ns since 1970), plus the loop's own time: they never
    jump. It is written in compressed chunks with an index if `chunked`; else record by record: nothing is kept back.
    """

    def __init__(self, stream: IO[bytes] | Any, heading: Heading, begin: int, *, chunked: bool) -> None:
        from mcap.writer import Writer  # noqa: PLC0415

        self.begin = begin
        self._layout = layout = heading.layout
        schemas = schemas_of(layout)
        self._cycles = Fixed(schemas[CYCLE], layout.joints)
        self._states = Fixed(schemas[JOINT_STATE], layout.joints, empty=("effort",))
        self._writer = Writer(stream, CHUNK, use_chunking=chunked)
        self._writer.start("ros2", f"layflat {__version__}")
        self._cycle, self._state, self._events = (
            self._writer.register_channel(
                topic, "cdr", self._writer.register_schema(kind, "ros2msg", schemas[kind].encode())
            )
            for topic, kind in (("/cycle", CYCLE), ("/joint_states", JOINT_STATE), ("/events", LOG))
        )
        start = datetime.fromtimestamp(begin / SECOND, UTC).isoformat()
        about = {"layflat_version": __version__, "machine_name": heading.machine_name, "start": start}
        told = {**about, "joints": json.dumps(layout.joints), "notes": json.dumps(heading.notes)}
        told["faults"] = json.dumps(FAULTS)
        self._writer.add_metadata(METADATA, told)
        self._writer.add_attachment(begin, begin, MACHINE, "application/json", heading.machine.encode())

    def add(self, rows: Array) -> None:
        """Add rows, (rows, width)."""
        if not len(rows):
            return
        columns = {name: self._layout.named(rows, name) for name in (*SHARED, *self._layout.by_joint)}
        stamps = self.begin + np.rint(columns["time"] * SECOND).astype(np.int64)
        cycles = self._cycles.encoded(stamps, columns)
        seen = {"position": columns["measured_angle"], "velocity": columns["averaged_velocity"]}
        states = self._states.encoded(stamps, seen)
        for stamp, cycle, state in zip(stamps.tolist(), cycles, states, strict=True):
            self._writer.add_message(self._cycle, stamp, cycle, stamp)
            self._writer.add_message(self._state, stamp, state, stamp)

    def write_event(self, event: Event) -> None:
        """Add an event."""
        stamp = self.begin + round(event.time * SECOND)
        self._writer.add_message(self._events, stamp, encoded_event(stamp, event), stamp)

    def finish(self) -> None:
        """Write the summary and the end; the stream stays open."""
        self._writer.finish()
