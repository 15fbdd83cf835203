"""Where in a log a demand was performed, and what was measured then.

| symbol | meaning | unit |
|---|---|---|
| d | time by which the log's cycles come after those of the demand: a part of a cycle | s |
"""

import numpy as np

from layflat.arrays import Array
from layflat.motion.trajectory import States

SAME = 1e-3  # by which the demand in a log may differ from one that was sent, rad
HALF = 0.6  # greatest d, in cycles: the nearest cycle is nearer, but for noise


def measured_during(demand: States, asked: Array, measured: Array, cycle: float) -> Array | None:
    """Return angles that were measured at the control cycles of a demand, (cycles, joints), rad.

    A rig's host has a clock of its own: the cycles of its log lie between those of the demand that it sent.

    Args:
        demand: a row a cycle.
        asked: demands in the log, (cycles of the log, joints), rad.
        measured: angles in the log, likewise.
        cycle: s.

    Returns:
        None where this demand was not asked for.
    """
    count = len(demand.angles)
    if len(asked) < count:
        return None
    windows = np.lib.stride_tricks.sliding_window_view(asked, count, axis=0)
    apart = np.nan_to_num(np.abs(windows - demand.angles.T).max(axis=(1, 2)), nan=np.inf)
    first = int(np.argmin(apart))
    error, v = asked[first : first + count] - demand.angles, demand.velocities
    d = float(np.clip(np.sum(error * v) / max(np.sum(v * v), 1e-12), -HALF * cycle, HALF * cycle))
    if not np.abs(error - d * v - 0.5 * d * d * demand.accelerations).max() <= SAME:
        return None
    at, cycles = first + np.arange(count) - d / cycle, np.arange(len(measured))
    return np.stack([np.interp(at, cycles, column) for column in measured.T], axis=1)
