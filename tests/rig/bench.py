"""A machine in motion with a driver before it, for tests: the laws of `sim`, a control cycle at a time, and what can break."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.control.gains import Measurement
from layflat.jit import kernel
from layflat.machine import Machine, parameters
from layflat.physics.delay import NOTHING_ASKED, delayed
from layflat.physics.joint import Drive, joint_at_rest
from layflat.physics.plant import advance
from layflat.physics.valve import commanded_opening, start_wave
from layflat.rig.clock import SECOND, Clock
from layflat.rig.driver import Capabilities, Command, Driver, FarState, LinkError, Reading
from layflat.sim.kernel import sense
from layflat.sim.run import FILLED

STEPS = 20

FREE = 9.0
"""In place of an opening: the spool is not held."""


@kernel
def through_a_cycle(arm, joints, states, lines, around, voltages, held, load, lost, k, cycle, steps):  # type: ignore[no-untyped-def]
    """States and delay lines after a control cycle; `lost` (joints, 2) is the share of each hose's air that escapes."""
    n = len(joints)
    joints, states, lines = list(joints), list(states), list(lines)
    h = cycle / steps
    drives = [Drive(0.0, 0.0, 0.0) for j in range(n)]
    waves = [start_wave(joints[j].valve, 0.0, h) for j in range(n)]
    for j in range(n):
        asked = commanded_opening(joints[j].valve, voltages[j])
        opening, lines[j] = delayed(lines[j], asked, joints[j].valve.delay / cycle)
        if abs(held[j]) <= 1.0:
            opening = held[j]
        drives[j] = Drive(opening, joints[j].brake_torque, load[j])
        waves[j] = start_wave(joints[j].valve, cycle * k, h)
        if abs(held[j]) <= 1.0:
            waves[j] = start_wave(joints[j].valve, 0.0, 0.0)
    for _ in range(steps):
        advance(arm, joints, states, drives, waves, around, h, 1)
        for j in range(n):
            a, b = states[j].hose_a, states[j].hose_b
            keep_a, keep_b = 1.0 - lost[j, 0] / steps, 1.0 - lost[j, 1] / steps
            if a.pressure < 1.05 * around.ambient_pressure:
                keep_a = 1.0
            if b.pressure < 1.05 * around.ambient_pressure:
                keep_b = 1.0
            states[j] = states[j]._replace(
                hose_a=a._replace(energy=keep_a * a.energy, mass=keep_a * a.mass),
                hose_b=b._replace(energy=keep_b * b.energy, mass=keep_b * b.mass),
            )
    return states, lines
