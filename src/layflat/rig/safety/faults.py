"""States of the supervisor; all faults with their reactions and detection times; a ledger of faults: the worst wins."""

from collections.abc import Sequence
from enum import IntEnum
from typing import Self


class RigState(IntEnum):
    """State of a rig; numbers as they stand in records."""

    OFF = 0  # no air; the valves are centred
    STARTING = 1  # air comes in slowly; the joints are held where they are
    READY = 2  # air is on; no demand has come yet
    MOVING = 3  # demands are obeyed
    HOLDING = 4  # the joints are held where they are, with air; a start leads to READY
    STOPPED = 5  # a controlled stop: the joints are held, then the hoses are vented; a start brings it again
    FAULT = 6  # a latched fault; a reset leads to OFF, or to HOLDING where the air was left on


class ValveMode(IntEnum):
    """Mode of the valves."""

    CENTRE = 0  # air off, all centred
    HOLD = 1  # air on; the controllers hold the joints
    FOLLOW = 2  # air on; the controllers follow the demands
    VENT_JOINT = 3  # air off; faulty joints open to one end, the others centred
    VENT = 4  # air off; all open to one end


MODE_HAS_AIR = [mode in {ValveMode.HOLD, ValveMode.FOLLOW} for mode in ValveMode]  # whether air is on, by mode


class Reaction(IntEnum):
    """Reaction to a fault, mildest first."""

    WARN = 0  # a message, and no more
    HOLD = 1  # the joints are held where they are, with air
    STOP = 2  # held, then depressurised
    VENT_JOINT = 3  # air off; the faulty joint's valve is opened to one end, the others are centred
    VENT = 4  # air off; all valves are opened to one end
    DUMP = 5  # the same; the device does it by itself, too, and obeys again only after a reset


class Fault(IntEnum):
    """All faults, by the numbers that stand in records: a greater one is worse.

    Each has a title for people, a reaction, a latch, and a detection time. NO_AIR is detected after the machine's
    `safety.start_time`.
    """

    title: str
    reaction: Reaction
    latched: bool  # whether it stays until a reset
    seconds: float  # detection time, s; 0 where cycles count
    cycles: int  # detection time in control cycles, where seconds do not count

    def __new__(
        cls, number: int, title: str = "", reaction: Reaction = Reaction.WARN, latched: bool = False,
        seconds: float = 0.0, cycles: int = 1,
    ) -> Self:  # fmt: skip
        """Make a row of the table."""
        fault = int.__new__(cls, number)
        fault._value_ = number
        fault.title, fault.reaction, fault.latched = title, reaction, latched
        fault.seconds, fault.cycles = seconds, cycles
        return fault

    NONE = 0
    RECORDER_DEAD = 1, "recorder dead: no new start", Reaction.WARN, False, 1.0
    DEMAND_LIMITED = 2, "demand too fast: limited", Reaction.WARN, False
    DEMAND_REFUSED = 3, "demand outside the working stroke: refused", Reaction.WARN, False
    CYCLE_MISSED = 4, "a cycle came too late and was left out", Reaction.WARN, False
    REPLY_LOST = 5, "a reply was lost", Reaction.WARN, False
    MODEL_DOUBTED = 6, "the control law gave up: its model does not fit the machine", Reaction.WARN, False
    FOLLOWING_ERROR = 7, "following error", Reaction.HOLD, True, 0.1
    BAD_COMMAND = 8, "command not a number or out of range: refused", Reaction.HOLD, True
    DEVICE_CENTRED = 9, "the device heard nothing and centred the valves", Reaction.HOLD, True
    SETPOINT_STALE = 10, "setpoint stale", Reaction.STOP, False, 0.1
    NO_AIR = 11, "the air did not come", Reaction.STOP, True, 5.0
    PRESSURE_FROZEN = 12, "pressure sensor frozen", Reaction.VENT_JOINT, True, 0.1
    ANGLE_FROZEN = (
        13, "angle does not change although it should: sensor frozen, or joint blocked", Reaction.VENT_JOINT, True, 0.1
    )  # fmt: skip
    ANGLE_AT_RAIL = 14, "angle sensor open or shorted", Reaction.VENT_JOINT, True, 0.0, 3
    SUPPLY_LOST = 15, "supply lost", Reaction.VENT, True, 0.1
    VALVE_UNRESPONSIVE = (
        16, "air does not answer the valve (stuck spool, burst or kinked hose)", Reaction.VENT, True, 0.2
    )  # fmt: skip
    LINK_LOST = 17, "link lost", Reaction.VENT, True, 0.0, 3
    OVER_PRESSURE = 18, "over-pressure", Reaction.VENT, True, 0.0, 2
    OUTSIDE_STROKE = 19, "outside the stroke", Reaction.VENT, True, 0.0, 2
    OVER_SPEED = 20, "over-speed", Reaction.VENT, True, 0.0, 2
    DEVICE_DUMPED = 21, "the device vented the hoses", Reaction.DUMP, True
    E_STOP = 22, "e-stop", Reaction.DUMP, True


class FaultLedger:
    """Ledger of the faults of a rig with joints of these names, present and latched."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = names
        self.clear()
        self.now = Fault.NONE  # worst of this cycle
        self.joints_now = [Fault.NONE] * len(names)  # worst of each joint in this cycle
        self.events: list[str] = []  # events to be recorded; the loop clears them
        self._before: set[tuple[Fault, int | None]] = set()
        self._noted: set[tuple[Fault, int | None]] = set()

    def clear(self) -> None:
        """Clear all latched faults, and the reaction to them."""
        self.latched = Fault.NONE  # worst latched fault
        self.joints = [Fault.NONE] * len(self._names)  # worst latched fault of each joint
        self.reaction = Reaction.WARN  # worst reaction of the latched faults

    @property
    def worst(self) -> Fault:
        """Return the worst fault that is latched or of this cycle."""
        return self.latched if self.latched >= self.now else self.now

    def worst_of(self, joint: int) -> Fault:
        """Return the worst fault of a joint that is latched or of this cycle."""
        return max(self.joints[joint], self.joints_now[joint])

    def new_cycle(self) -> None:
        """Begin a cycle without faults; one that lasts from the cycle before adds no further event."""
        if self._noted or self._before:
            self._before, self._noted = self._noted, set()
            self.now = Fault.NONE
            for j in range(len(self.joints_now)):
                self.joints_now[j] = Fault.NONE

    def note(self, fault: Fault, joint: int | None = None) -> None:
        """Add a fault of this cycle, of a joint by its number or of the whole machine (None); latch one that latches.

        A fault that was not there in the cycle before adds an event.
        """
        if (fault, joint) in self._noted:
            return
        self._noted.add((fault, joint))
        if (fault, joint) not in self._before:
            where = "" if joint is None else f"joint {self._names[joint]!r}: "
            self.events.append(f"{where}{fault.title}")
        self.now = max(self.now, fault)
        if joint is not None:
            self.joints_now[joint] = max(self.joints_now[joint], fault)
        if fault.latched:
            self.latched = max(self.latched, fault)
            self.reaction = max(self.reaction, fault.reaction)
            if joint is not None:
                self.joints[joint] = max(self.joints[joint], fault)
