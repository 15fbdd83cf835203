"""States of the supervisor, and all faults with their reactions and detection times."""

from collections import namedtuple
from collections.abc import Iterable
from enum import IntEnum
from typing import Any, Self


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


def numbers_of(kind: Iterable[IntEnum], name: str) -> Any:
    """Return the numbers of an enumeration as a named tuple of floats, of this name, which compiled code takes."""
    members = list(kind)
    row: Any = namedtuple(name, [one.name for one in members])  # type: ignore[misc]
    return row(*map(float, members))


STATE_NO, MODE_NO = numbers_of(RigState, "StateNumbers"), numbers_of(ValveMode, "ModeNumbers")
REACTION_NO, FAULT_NO = numbers_of(Reaction, "ReactionNumbers"), numbers_of(Fault, "FaultNumbers")
FIRST_OF_REACTION = [min(fault for fault in Fault if fault.reaction >= reaction) for reaction in Reaction]
"""Mildest fault with a reaction: worse faults have it or a worse one."""
