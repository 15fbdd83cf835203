"""What is watched of the machine as a whole: its supply, and every joint through its own watch."""

from __future__ import annotations

from enum import IntEnum
from math import inf

import numpy as np
from numpy.typing import NDArray

from layflat.control.gains import Memory, Status
from layflat.machine import Machine, parameters
from layflat.physics.air_balance import follow_hoses
from layflat.rig.driver import Reading
from layflat.rig.safety.faults import TABLE, Fault
from layflat.rig.safety.joint_watch import RIPPLE_AFTER, JointWatch, Signals
from layflat.rig.safety.lasting import Lasting, Samples
from layflat.rig.safety.limits import Limits

Array = NDArray[np.float64]

FILLED = 0.75
"""Of the supply's pressure: what hoses hold whose valve leaks equally to supply and exhaust."""

EMPTIES = 0.03
"""Time that a supply line takes to show that nothing comes any more, s."""

LONG_TERM = Memory._fields.index("long_term")
SPEED, AVERAGED = Status._fields.index("velocity"), Status._fields.index("differential_pressure")


class Level(IntEnum):
    """How much there is to watch."""

    SENSORS = 0
    """No air: sensors alone."""
    MOTION = 1
    """Air may come or go."""
    AIR = 2
    """Air is there, and the valves obey."""


class MachineWatch:
    """Detectors of a machine.

    Args:
        machine: with valve and sensors.
        cycle: of the loop, s.
        each: limits of the joints.
    """

    def __init__(self, machine: Machine, cycle: float, each: list[Limits]) -> None:
        assert machine.valve is not None
        self.joints = [JointWatch(one, cycle) for one in each]
        self.found = [Fault.NONE] * len(each)
        """The worst of each joint in this cycle."""
        safety, gauge = machine.safety, machine.supply.pressure_gauge
        self._exhaust = machine.supply.ambient_pressure
        self._low = self._exhaust + safety.supply_low * gauge
        self._ready = self._exhaust + safety.supply_ready * gauge
        self._high = self._exhaust + safety.overpressure * gauge
        self._ripple_seen = all(one.ripple > 0.0 for one in each)
        self._parts = np.array([parameters.air_parts(machine, name) for name in machine.joints])
        self._beliefs = np.zeros((1, len(each), 4))
        self._openings = np.zeros(len(each))
        self._centre, self._per_volt = machine.valve.centre_voltage, 1.0 / machine.valve.volts_to_full
        self._cycle = cycle
        self.reset()

    def reset(self) -> None:
        """Forget what was seen; what the hoses hold is kept."""
        cycle = self._cycle
        for joint in self.joints:
            joint.reset()
        self._pressed = Samples(TABLE[Fault.OVER_PRESSURE].cycles)
        self._gone = Lasting(TABLE[Fault.SUPPLY_LOST].seconds - EMPTIES, cycle)
        self._still = Lasting(TABLE[Fault.SUPPLY_LOST].seconds - RIPPLE_AFTER * cycle, cycle)

    def begin(self, reading: Reading, *, filled: bool) -> None:
        """Believe that the hoses are empty, or filled as they are when left to themselves."""
        held = FILLED * reading.supply if filled else self._exhaust
        for j, (angle, pressure) in enumerate(zip(reading.angles, reading.pressures, strict=True)):
            half = 0.5 * pressure if np.isfinite(pressure) else 0.0
            self._beliefs[0, j] = (max(held, self._exhaust) + half, max(held, self._exhaust) - half, angle, 0.0)

    def air_is_there(self, reading: Reading) -> bool:
        """Whether supply and ripple are those of a machine that can move."""
        if not reading.supply >= self._ready:
            return False
        return not self._ripple_seen or all(joint.limits.ripple < joint.ripple < inf for joint in self.joints)

    def look(
        self, reading: Reading, status: Array, memory: Array, voltages: Array, demands: list[float],
        lead: float, elapsed: float, level: Level,
    ) -> Fault:  # fmt: skip
        """The worst fault of the machine as a whole; those of the joints stand in `found`.

        Args:
            reading: of this cycle.
            status: of the controllers in the cycle before, (1, joints, STATUS).
            memory: of the controllers, (1, joints, MEMORY).
            voltages: that acted since then, V, (joints,).
            demands: as the controllers were given them, rad.
            lead: of the demands, the greatest, rad.
            elapsed: s.
            level: what there is to watch.
        """
        openings = self._openings
        np.subtract(voltages, memory[0, :, LONG_TERM], out=openings)
        openings -= self._centre
        openings *= self._per_volt
        follow_hoses(
            self._parts,
            self._beliefs,
            openings,
            reading.angles,
            reading.pressures,
            reading.supply,
            self._exhaust,
            elapsed,
        )
        rows, beliefs = status[0].tolist(), self._beliefs[0].tolist()
        angles, pressures = reading.angles.tolist(), reading.pressures.tolist()
        for joint, pressure in zip(self.joints, pressures, strict=True):
            joint.listen(pressure)
        fault, dead = self._supply(reading.supply, elapsed, level)
        for j, joint in enumerate(self.joints):
            row = rows[j]
            seen = Signals(angles[j], pressures[j], row[AVERAGED], row[SPEED], beliefs[j][3], demands[j], lead)
            self.found[j] = _of_joint(joint, seen, elapsed, level, alone=not dead)
        return fault

    def _supply(self, supply: float, elapsed: float, level: Level) -> tuple[Fault, bool]:
        """Fault of the supply, and whether several joints are without ripple, so that it is not one joint's fault."""
        high = self._pressed(not supply < self._high)
        if level is not Level.AIR:
            return (Fault.OVER_PRESSURE if high else Fault.NONE), False
        dead = len(self.joints) > 1 and self._ripple_seen
        if dead:
            for joint in self.joints:
                dead = dead and joint.ripple < joint.limits.ripple
        gone, still = self._gone(supply < self._low, elapsed), self._still(dead, elapsed)
        lost = Fault.SUPPLY_LOST if gone or still else Fault.NONE
        return (Fault.OVER_PRESSURE if high else lost), dead or supply < self._low


def _of_joint(joint: JointWatch, seen: Signals, elapsed: float, level: Level, *, alone: bool) -> Fault:
    """The worst fault of a joint."""
    worst = joint.sensors(seen)
    if level is not Level.SENSORS:
        worst = max(worst, joint.motion(seen, elapsed))
    if level is Level.AIR:
        worst = max(worst, joint.air(seen, elapsed, alone=alone))
        if joint.following(seen, elapsed):
            worst = max(worst, Fault.FOLLOWING_ERROR)
    return worst
