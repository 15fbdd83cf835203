"""What is watched of the machine as a whole: its supply, and every joint through its own watch."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from layflat.control.gains import Memory
from layflat.control.watch import (
    AIR,
    ANGLE_FROZEN,
    AT_RAIL,
    FAST,
    FRESH,
    OFF_TRACK,
    OUTSIDE,
    PRESSED,
    PRESSURE_FROZEN,
    VALVE_UNRESPONSIVE,
    WATCH_MEMORY,
    Limits,
    WatchMemory,
    watch_joints,
)  # fmt: skip
from layflat.machine import Machine, parameters
from layflat.physics.air_balance import follow_hoses
from layflat.physics.joint import FILLED
from layflat.rig.driver import Reading
from layflat.rig.safety.debounce import CountDebounce, TimeDebounce
from layflat.rig.safety.faults import TABLE, Fault
from layflat.rig.safety.limits import RIPPLE_AFTER, coupling, patience

Array = NDArray[np.float64]

ENOUGH = 0.4
"""Of the supply's gauge pressure: joints with less are soft, and fling each other further than filled ones."""

UNEVEN, CALM = 0.3, 0.1
"""A cycle that is longer or shorter by this share is uneven; for so long after it the air is not judged, s."""

DIPS = 3
"""CountDebounce of low pressure after which a supply is lost: as long as valves are open, hoses empty into its line."""

LONG_TERM = Memory._fields.index("long_term")
RIPPLE, LEAST = WatchMemory._fields.index("ripple"), Limits._fields.index("ripple")


FAULTS = (
    (FAST, Fault.OVER_SPEED),
    (OUTSIDE, Fault.OUTSIDE_STROKE),
    (PRESSED, Fault.OVER_PRESSURE),
    (VALVE_UNRESPONSIVE, Fault.VALVE_UNRESPONSIVE),
    (AT_RAIL, Fault.ANGLE_AT_RAIL),
    (ANGLE_FROZEN, Fault.ANGLE_FROZEN),
    (PRESSURE_FROZEN, Fault.PRESSURE_FROZEN),
    (OFF_TRACK, Fault.FOLLOWING_ERROR),
)
"""Faults of the bits that a watch sets, worst first."""


class MachineWatch:
    """Detectors of a machine.

    Args:
        machine: with valve and sensors.
        cycle: of the loop, s.
        each: limits of the joints.
    """

    def __init__(self, machine: Machine, cycle: float, each: list[Limits]) -> None:
        assert machine.valve is not None
        self._limits, self._patience = np.array(each), np.array(patience(cycle))
        self._memory = np.zeros((1, len(each), WATCH_MEMORY))
        self._coupling = coupling(machine)
        self._bits = np.zeros(len(each), np.int64)
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
        self._neutrals = np.zeros(len(each))
        self._centre, self._per_volt = machine.valve.centre_voltage, 1.0 / machine.valve.volts_to_full
        self._cycle = cycle
        self.reset()

    def reset(self) -> None:
        """Forget what was seen; what the hoses hold is kept."""
        cycle = self._cycle
        self._memory[0] = FRESH
        self._even = CALM
        self._pressed = CountDebounce(TABLE[Fault.OVER_PRESSURE].cycles)
        self._gone = CountDebounce(DIPS)
        self._still = TimeDebounce(TABLE[Fault.SUPPLY_LOST].seconds - RIPPLE_AFTER * cycle, cycle)

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
        ripple = self._memory[0, :, RIPPLE]
        return not self._ripple_seen or bool(((self._limits[:, LEAST] < ripple) & (ripple < inf)).all())

    def hoses_are_filled(self, supply: float) -> bool:
        """Whether every pair of hoses holds what it takes to move well; `supply` absolute, Pa."""
        enough = self._exhaust + ENOUGH * (supply - self._exhaust)
        return bool((self._beliefs[0, :, :2].sum(axis=1) >= 2.0 * enough).all())

    def look(
        self, reading: Reading, status: Array, memory: Array, voltages: Array, demands: Array,
        lead: float, elapsed: float, level: int,
    ) -> Fault:  # fmt: skip
        """The worst fault of the machine as a whole; those of the joints stand in `found`.

        Args:
            reading: of this cycle.
            status: of the controllers in the cycle before, (1, joints, STATUS).
            memory: of the controllers, (1, joints, MEMORY).
            voltages: that acted since then, V, (joints,).
            demands: as the controllers were given them, rad, (joints,).
            lead: of the demands, the greatest, rad.
            elapsed: s.
            level: what there is to watch (see control/watch.py).
        """
        angles, pressures, supply = reading.angles, reading.pressures, reading.supply
        np.add(memory[0, :, LONG_TERM], self._centre, out=self._neutrals)
        follow_hoses(
            self._parts, self._beliefs, voltages, self._neutrals, self._per_volt, angles, pressures, supply,
            self._exhaust, elapsed,
        )  # fmt: skip
        # When a late cycle's voltage reached its valve, and when it was sampled, is not known well enough.
        uneven = abs(elapsed - self._cycle) > UNEVEN * self._cycle
        self._even = 0.0 if uneven else self._even + elapsed
        trusted = supply >= self._low and self._even >= CALM
        still = watch_joints(
            self._limits, self._patience, self._coupling(angles), self._memory, angles, pressures, status,
            self._beliefs, demands, lead, elapsed, level, trusted, self._bits,
        )  # fmt: skip
        for j, bits in enumerate(self._bits.tolist()):
            self.found[j] = _worst(bits) if bits else Fault.NONE
        return self._supply(supply, still, elapsed, level)

    def _supply(self, supply: float, still: int, elapsed: float, level: int) -> Fault:
        """Fault of the supply; that several joints have no ripple is no fault of theirs."""
        if self._pressed(not supply < self._high):
            return Fault.OVER_PRESSURE
        airy, n = level >= AIR, len(self.found)
        gone = self._gone(airy and supply < self._low)
        return Fault.SUPPLY_LOST if self._still(airy and 1 < n == still, elapsed) or gone else Fault.NONE


def _worst(bits: int) -> Fault:
    return next(fault for bit, fault in FAULTS if bits & bit)
