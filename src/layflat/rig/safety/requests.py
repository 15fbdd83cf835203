"""Requests to a device that runs the machine's control law itself, and its status, as bytes of frames.

The tables in docs/rig-wires.md are those of this module.
"""

import struct
from collections.abc import Sequence
from math import nan
from typing import NamedTuple, Self
from zlib import crc32

import numpy as np

from layflat.arrays import Array
from layflat.lanes import leaves
from layflat.machine import Machine, parameters
from layflat.rig.driver import SensorReading
from layflat.rig.record import RowLayout
from layflat.rig.safety.faults import Fault, RigState, ValveMode
from layflat.rig.safety.limits import joint_settings, rig_settings
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.wire import Wire, WireError

EDGE_BITS = 4  # of each count of edges
UNRECORDED_FLAG = 1  # of a request: nothing is recorded, so that no start is allowed
VENTED_FLAG = 1  # of a status: the air is off, and the time for venting the hoses has passed
NO_JOINT = 255  # in the place of an event's joint: the machine as a whole
REQUEST_HEAD = struct.Struct(">HBBHHdd")
STATUS_HEAD = struct.Struct(">5B")  # behind the words of a reading
EVENTS_HEAD = struct.Struct(">HHB")


class DeviceRequest(NamedTuple):
    """Request to a device that runs the control law: counts of the operator's requests, and the demands in force."""

    demands: Sequence[float]  # rad, (joints,); NaN where there is none
    velocities: Sequence[float]  # rad/s; NaN: derived, as the next
    accelerations: Sequence[float]  # rad/s2
    edges: tuple[int, int, int, int] = (0, 0, 0, 0)  # starts, stops, holds and resets so far
    outputs: int = 0  # digital outputs that are to be on, as bits
    switches: int = 0  # a bit of each output that changes as it is switched
    recording: bool = True  # whether rows reach the disk
    events: int = 0  # number of events of the device that have been received
    age: float = 0.0  # time since the last message of the host, s
    since: float = 0.0  # time since the target instant of the demands, s

    @classmethod
    def first(cls, joints: int) -> Self:
        """Return the request of a host that has not requested anything yet."""
        nothing = [nan] * joints
        return cls(nothing, nothing, nothing)

    def following(self, request: HostRequest, *, recording: bool, events: int) -> Self:
        """Return the request after this one.

        Args:
            request: what the host requests in a cycle; its edges are added to the counts.
            recording: whether rows reach the disk.
            events: number of events of the device that have been received.
        """
        edges = request.start, request.stop, request.hold, request.reset
        starts, stops, holds, resets = (count + edge for count, edge in zip(self.edges, edges, strict=True))
        outputs, switches = self.outputs, self.switches
        for number, on in request.switched:
            outputs, switches = outputs & ~(1 << number) | on << number, switches ^ 1 << number
        nothing = [nan] * len(request.demands)
        return self._replace(
            demands=request.demands, velocities=request.velocities or nothing,
            accelerations=request.accelerations or nothing, edges=(starts, stops, holds, resets), outputs=outputs,
            switches=switches, recording=recording, events=events, age=request.age, since=request.since,
        )  # fmt: skip


class DeviceStatus(NamedTuple):
    """Status of a device that runs the control law, after its last control cycle."""

    reading: SensorReading  # of that cycle
    state: RigState
    mode: ValveMode
    vented: bool  # whether the air is off and the time for venting the hoses has passed
    outputs: int  # digital outputs that are on, as bits
    fault: Fault  # worst that is latched or of that cycle
    joint_faults: list[Fault]
    cycle: int  # number of the cycle, 16 bits
    events_before: int  # number of events before `events`, 16 bits
    events: list[tuple[int, int]]  # number of each event, and its joint; -1: the machine as a whole
    signals: Array  # columns of `record.RowLayout` but the fault, in single precision, (joints, numbers)


class RequestWire(NamedTuple):
    """Encoding of a machine's requests and statuses."""

    words: Wire
    signals: int  # numbers of a joint

    @classmethod
    def for_machine(cls, machine: Machine) -> Self:
        """Return the encoding for a machine; raise MachineError if it has no valve or sensors."""
        return cls(Wire.for_machine(machine), len(RowLayout.for_machine(machine).by_joint) - 1)

    @property
    def joints(self) -> int:
        """Return the number of joints."""
        return self.words.joints

    def request_bytes(self, request: DeviceRequest) -> bytes:
        """Return a request as the payload of a frame."""
        counts = sum((count % (1 << EDGE_BITS)) << EDGE_BITS * i for i, count in enumerate(request.edges))
        flags = 0 if request.recording else UNRECORDED_FLAG
        head = counts, request.outputs, request.switches, flags, request.events, request.age, request.since
        numbers = np.array([request.demands, request.velocities, request.accelerations]).T
        return REQUEST_HEAD.pack(*head) + numbers.astype(">f8").tobytes()

    def request(self, payload: bytes) -> DeviceRequest:
        """Return the request of a payload; raise WireError if it is none."""
        if len(payload) != REQUEST_HEAD.size + 24 * self.joints:
            raise WireError(f"a request of {len(payload)} bytes, which is none of this rig's")
        counts, outputs, switches, flags, events, age, since = REQUEST_HEAD.unpack_from(payload)
        numbers = np.frombuffer(payload, ">f8", offset=REQUEST_HEAD.size).reshape(-1, 3)
        demands, velocities, accelerations = numbers.T.tolist()
        starts, stops, holds, resets = (counts >> EDGE_BITS * i & (1 << EDGE_BITS) - 1 for i in range(4))
        edges = starts, stops, holds, resets
        return DeviceRequest(
            demands, velocities, accelerations, edges, outputs, switches, not flags & UNRECORDED_FLAG, events, age,
            since,
        )  # fmt: skip

    def status_bytes(self, status: DeviceStatus) -> list[bytes]:
        """Return a status as the payloads of its frames: the status itself, then the signals of each joint."""
        words = self.words.reading_words(status.reading)
        flags = VENTED_FLAG if status.vented else 0
        head = status.state, status.mode, flags, status.outputs, status.fault
        events = [item for number, joint in status.events for item in (number, joint % 256)]
        counts = EVENTS_HEAD.pack(status.cycle, status.events_before, len(status.events))
        first = struct.pack(f">{len(words)}H", *words) + STATUS_HEAD.pack(*head) + bytes(status.joint_faults)
        return [
            first + counts + bytes(events),
            *(bytes([j]) + row.astype(">f4").tobytes() for j, row in enumerate(status.signals)),
        ]

    def status(self, payloads: Sequence[bytes]) -> DeviceStatus:
        """Return the status of the payloads of its frames; raise WireError if they are none of this rig's."""
        first, *others = payloads
        faults_at = 2 * self.words.reading_size + STATUS_HEAD.size
        events_at = faults_at + self.joints + EVENTS_HEAD.size
        sizes = [1 + 4 * self.signals] * self.joints
        if len(first) < events_at or [len(one) for one in others] != sizes:
            raise WireError("a status of another size than this rig's")
        cycle, before, count = EVENTS_HEAD.unpack_from(first, faults_at + self.joints)
        if len(first) != events_at + 2 * count or any(one[0] != j for j, one in enumerate(others)):
            raise WireError("a status of which a part is missing")
        reading = self.words.reading(struct.unpack_from(f">{self.words.reading_size}H", first))
        state, mode, flags, outputs, fault = STATUS_HEAD.unpack_from(first, 2 * self.words.reading_size)
        numbers = first[events_at:]
        events = [(number, -1 if j == NO_JOINT else j) for number, j in zip(numbers[::2], numbers[1::2], strict=True)]
        try:
            faults = list(map(Fault, first[faults_at : faults_at + self.joints]))
            states = RigState(state), ValveMode(mode), bool(flags & VENTED_FLAG), outputs, Fault(fault)
        except ValueError as error:
            raise WireError(f"a status with an unknown number ({error})") from None
        signals = np.array([np.frombuffer(one, ">f4", offset=1) for one in others], float)
        return DeviceStatus(reading, *states, faults, cycle, before, events, signals)


def settings_digest(machine: Machine) -> int:
    """Return a digest, 32 bits, of all numbers on which control law and supervisor of a machine depend.

    Raises:
        MachineError: the machine lacks valve, sensors, controller or gains.
    """
    names = list(machine.joints)
    tuples = (
        Wire.for_machine(machine), rig_settings(machine), *(joint_settings(machine, name) for name in names),
        parameters.arm(machine), parameters.control(machine),
    )  # fmt: skip
    numbers = np.array([float(number) for one in tuples for number in leaves(one)], "<f8")
    columns = ",".join([*names, *RowLayout.for_machine(machine).by_joint])
    return crc32(columns.encode(), crc32(numbers.tobytes()))
