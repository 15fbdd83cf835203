"""How fast a demand moves that is given by its angles alone, a row a control cycle.

A demand that jumps asks for a place, not for a motion: a rate counts where it lasts.

| symbol | meaning | unit |
|---|---|---|
| f_k | (x_(k+1) - x_k) / T, the rate from sample k to the next | |
| T | control cycle | s |
"""

import numpy as np

from layflat.arrays import Array

SURGE = 100.0  # change of velocity per time that still is a motion, rad/s2: above it, it is a jump
JERK = 5e3  # the same of an acceleration, rad/s3


def lasting_rate(x: Array, cycle: float, limit: float = JERK) -> Array:
    """Rate of what changes from row to row, (cycles, joints), where it lasts for more than a cycle, else zero.

    It is that of the cycle to come, so that a demand that sets off at once has its velocity from its first cycle on.
    """
    f = np.diff(x, axis=0, append=x[-1:]) / cycle
    if len(x) > 1:
        f[-1] = f[-2]
    close = np.abs(np.diff(f, axis=0)) <= limit * cycle
    never = np.zeros_like(x, dtype=bool)
    after, before = never.copy(), never.copy()
    after[:-1], before[1:] = close, close
    return np.where(after | before, f, 0.0)


def derived_rates(angles: Array, cycle: float) -> tuple[Array, Array]:
    """Velocity (rad/s) and acceleration (rad/s2) of a demand, (cycles, joints) each, from its angles (rad)."""
    velocity = lasting_rate(angles, cycle, SURGE)
    return velocity, lasting_rate(velocity, cycle)
