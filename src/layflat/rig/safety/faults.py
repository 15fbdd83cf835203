"""The table of all faults: how soon each is found and what is then done. The worst one wins."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple


class Reaction(IntEnum):
    """What a fault leads to, mildest first."""

    TELL = 0
    """LoopMessage, and no more."""
    HOLD = 1
    """The joints are held where they are, with air."""
    STOP = 2
    """Held, then depressurised."""
    VENT_JOINT = 3
    """Air off; the faulty joint's valve is opened to one end, the others are centred."""
    VENT = 4
    """Air off; all valves are opened to one end."""
    DUMP = 5
    """The same; the device does it by itself, too, and obeys again only after a reset."""


class Fault(IntEnum):
    """Numbers of the faults, as they stand in records; a greater one is worse."""

    NONE = 0
    RECORDER_DEAD = 1
    DEMAND_LIMITED = 2
    DEMAND_REFUSED = 3
    CYCLE_MISSED = 4
    REPLY_LOST = 5
    FOLLOWING_ERROR = 6
    BAD_COMMAND = 7
    DEVICE_CENTRED = 8
    SETPOINT_STALE = 9
    NO_AIR = 10
    PRESSURE_FROZEN = 11
    ANGLE_FROZEN = 12
    ANGLE_AT_RAIL = 13
    SUPPLY_LOST = 14
    VALVE_UNRESPONSIVE = 15
    LINK_LOST = 16
    OVER_PRESSURE = 17
    OUTSIDE_STROKE = 18
    OVER_SPEED = 19
    DEVICE_DUMPED = 20
    E_STOP = 21


class Entry(NamedTuple):
    """A row of the table: what people read, what is done, and how soon it is found."""

    title: str
    reaction: Reaction
    latched: bool
    """Whether it stays until a reset."""
    seconds: float = 0.0
    """Found within so long of its beginning, s; 0 where cycles count."""
    cycles: int = 1
    """Found in so many control cycles, where seconds do not count."""


TABLE: dict[Fault, Entry] = {
    Fault.RECORDER_DEAD: Entry("recorder dead: no new start", Reaction.TELL, False, seconds=1.0),
    Fault.DEMAND_LIMITED: Entry("demand too fast: limited", Reaction.TELL, False),
    Fault.DEMAND_REFUSED: Entry("demand outside the working stroke: refused", Reaction.TELL, False),
    Fault.CYCLE_MISSED: Entry("a cycle came too late and was left out", Reaction.TELL, False),
    Fault.REPLY_LOST: Entry("a reply was lost", Reaction.TELL, False),
    Fault.FOLLOWING_ERROR: Entry("following error", Reaction.HOLD, True, seconds=0.1),
    Fault.BAD_COMMAND: Entry("command not a number or out of range: refused", Reaction.HOLD, True),
    Fault.DEVICE_CENTRED: Entry("the device heard nothing and centred the valves", Reaction.HOLD, True),
    Fault.SETPOINT_STALE: Entry("setpoint stale", Reaction.STOP, False, seconds=0.1),
    Fault.NO_AIR: Entry("the air did not come", Reaction.STOP, True, seconds=5.0),
    Fault.PRESSURE_FROZEN: Entry("pressure sensor frozen", Reaction.VENT_JOINT, True, seconds=0.1),
    Fault.ANGLE_FROZEN: Entry(
        "angle does not change although it should: sensor frozen, or joint blocked",
        Reaction.VENT_JOINT,
        True,
        seconds=0.1,
    ),
    Fault.ANGLE_AT_RAIL: Entry("angle sensor open or shorted", Reaction.VENT_JOINT, True, cycles=3),
    Fault.SUPPLY_LOST: Entry("supply lost", Reaction.VENT, True, seconds=0.1),
    Fault.VALVE_UNRESPONSIVE: Entry(
        "air does not answer the valve (stuck spool, burst or kinked hose)", Reaction.VENT, True, seconds=0.2
    ),
    Fault.LINK_LOST: Entry("link lost", Reaction.VENT, True, cycles=3),
    Fault.OVER_PRESSURE: Entry("over-pressure", Reaction.VENT, True, cycles=2),
    Fault.OUTSIDE_STROKE: Entry("outside the stroke", Reaction.VENT, True, cycles=2),
    Fault.OVER_SPEED: Entry("over-speed", Reaction.VENT, True, cycles=2),
    Fault.DEVICE_DUMPED: Entry("the device let out the air", Reaction.DUMP, True),
    Fault.E_STOP: Entry("e-stop", Reaction.DUMP, True),
}
"""Every fault but NONE. That of the air which does not come takes the machine's `safety.start_time`."""


def reaction(fault: int) -> Reaction:
    """What a fault leads to; that of no fault is to tell."""
    return REACTIONS[fault]


REACTIONS = [Reaction.TELL, *(TABLE[fault].reaction for fault in sorted(TABLE))]
LATCHED = [False, *(TABLE[fault].latched for fault in sorted(TABLE))]
"""The same by number, for use in every cycle."""
