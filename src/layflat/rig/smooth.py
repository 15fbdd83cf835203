"""Smooth motions of all joints from one place to another, all at once, for arms that are asked as they go."""

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.trajectory import QUINTIC_PEAKS, States, quintic
from layflat.rig.abilities import DemandLimits, demand_limits


def smooth(
    machine: Machine, start: Array, end: Array, share: float, limits: DemandLimits | None = None
) -> States:  # fmt: skip
    """Return a motion from rest to rest by a polynomial of fifth degree, a row a control cycle.

    Args:
        machine: whose joints move.
        start: angles, rad, (joints,).
        end: angles, rad, (joints,).
        share: of what every posture of the arm can do, 0..1, that its speeds and accelerations have at most.
        limits: of the machine's demands, where they are known: to find them takes 10 ms.
    """
    can, way = limits or demand_limits(machine), np.abs(end - start)
    slow = np.maximum(
        QUINTIC_PEAKS[0] * way / (share * can.speed), np.sqrt(QUINTIC_PEAKS[1] * way / (share * can.braking))
    )
    T = max(float(slow.max()), machine.cycle)
    place, speed, surge = quintic(np.arange(0.0, T + machine.cycle, machine.cycle)[:, None] / T)
    L = end - start
    return States(start + L * place, L * speed / T, L * surge / T**2)
