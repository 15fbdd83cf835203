"""The table of all faults, how soon each is found and what is done, and a ledger of those found; the worst wins."""

from collections.abc import Sequence
from enum import IntEnum
from typing import Self


class Reaction(IntEnum):
    """What a fault leads to, mildest first."""

    WARN = 0  # a message, and no more
    HOLD = 1  # the joints are held where they are, with air
    STOP = 2  # held, then depressurised
    VENT_JOINT = 3  # air off; the faulty joint's valve is opened to one end, the others are centred
    VENT = 4  # air off; all valves are opened to one end
    DUMP = 5  # the same; the device does it by itself, too, and obeys again only after a reset


class Fault(IntEnum):
    """All faults, by the numbers that stand in records: a greater one is worse.

    Each has the title that people read, a reaction, whether it is latched, and how soon it is found. That of the air
    which does not come takes the machine's `safety.start_time`.
    """

    title: str
    reaction: Reaction
    latched: bool  # whether it stays until a reset
    seconds: float  # found within so long of its beginning, s; 0 where cycles count
    cycles: int  # found in so many control cycles, where seconds do not count

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
    DEVICE_DUMPED = 21, "the device let out the air", Reaction.DUMP, True
    E_STOP = 22, "e-stop", Reaction.DUMP, True


class Ledger:
    """Faults of a rig with joints of these names."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = names
        self.clear()
        self.now = Fault.NONE  # the worst found in this cycle
        self.joints_now = [Fault.NONE] * len(names)  # the worst of each joint found in this cycle
        self.events: list[str] = []  # what has to be told; who tells it clears it
        self._before: set[tuple[Fault, int | None]] = set()
        self._noted: set[tuple[Fault, int | None]] = set()

    def clear(self) -> None:
        """A reset: nothing is latched any more."""
        self.latched = Fault.NONE  # the worst that stays until a reset
        self.joints = [Fault.NONE] * len(self._names)  # the worst of each joint that stays until a reset
        self.reaction = Reaction.WARN  # the worst that the latched faults ask for

    @property
    def worst(self) -> Fault:
        """Latched or found in this cycle."""
        return self.latched if self.latched >= self.now else self.now

    def worst_of(self, joint: int) -> Fault:
        """The same of a joint."""
        return max(self.joints[joint], self.joints_now[joint])

    def new_cycle(self) -> None:
        """Forget what was found in the cycle before, so that it is told again only if it comes again."""
        if self._noted or self._before:
            self._before, self._noted = self._noted, set()
            self.now = Fault.NONE
            for j in range(len(self.joints_now)):
                self.joints_now[j] = Fault.NONE

    def note(self, fault: Fault, joint: int | None = None) -> None:
        """A fault was found in this cycle, of a joint or of the machine as a whole."""
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
