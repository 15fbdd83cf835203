"""Smooth motions of all joints from one place to another, all at once, for arms that are asked as they go."""

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.trajectory import States
from layflat.rig.abilities import DemandLimits, demand_limits

PEAKS = 15.0 / 8.0, 10.0 / 3.0**0.5  # of a polynomial of fifth degree: velocity over L/T, acceleration over L/T2


def fifth(share: Array) -> tuple[Array, Array, Array]:
    """Return place, velocity and acceleration of a polynomial of fifth degree at shares of its time, (times, 1)."""
    x = np.minimum(share, 1.0)[:, None]
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2), 30.0 * (x - x**2) ** 2, 60.0 * x * (1 - x) * (1 - 2 * x)


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
    slow = np.maximum(PEAKS[0] * way / (share * can.speed), np.sqrt(PEAKS[1] * way / (share * can.braking)))
    T = max(float(slow.max()), machine.cycle)
    place, speed, surge = fifth(np.arange(0.0, T + machine.cycle, machine.cycle) / T)
    L = end - start
    return States(start + L * place, L * speed / T, L * surge / T**2)
