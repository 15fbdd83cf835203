"""Height of a measured loop: one definition for joints and rods."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from layflat.jit import kernel

Array = NDArray[np.float64]

PLAY = 0.05
"""The way has turned once the motion has come back by this share of its range."""

MIDDLE, BINS = 0.8, 20
"""Share of the range in which a height is taken, and into how many parts it is divided."""


@kernel
def _ways(motion, play):  # type: ignore[no-untyped-def]
    """+1 on the way up, -1 on the way down, 0 before the first of them is sure; a way begins at its turning point."""
    ways = np.zeros(len(motion))
    low, high, way = 0, 0, 0.0
    for i in range(len(motion)):
        if motion[i] > motion[high]:
            high = i
        if motion[i] < motion[low]:
            low = i
        if way <= 0.0 and motion[i] > motion[low] + play:
            way, high = 1.0, i
            ways[low : i + 1] = way
        elif way >= 0.0 and motion[i] < motion[high] - play:
            way, low = -1.0, i
            ways[high : i + 1] = way
        ways[i] = way
    return ways


def ways(motion: Array) -> Array:
    """Which way a motion goes, (samples,): up 1, down -1, 0 before that is sure; noise does not turn it."""
    motion = np.ascontiguousarray(motion, dtype=np.float64)
    return np.asarray(_ways(motion, PLAY * float(np.ptp(motion))))


def loop_height(motion: Array, effort: Array) -> float:
    """Mean effort on one way less that on the way back, over the middle of the range; never negative.

    The middle 80 % of the range are divided into 20 parts. In each the mean of all samples on the way down is taken
    from the mean of those on the way up; the height is the size of the mean over all parts that have both.

    Args:
        motion: angle or position, (samples,).
        effort: torque or force; samples that are no numbers are left out.
    """
    way = ways(motion)
    low, reach = float(motion.min()), float(np.ptp(motion))
    edges = low + reach * np.linspace(0.5 - MIDDLE / 2, 0.5 + MIDDLE / 2, BINS + 1)
    part = np.digitize(motion, edges)
    gaps = []
    for k in range(1, BINS + 1):
        there = (part == k) & np.isfinite(effort)
        up, down = effort[there & (way > 0)], effort[there & (way < 0)]
        if len(up) and len(down):
            gaps.append(float(up.mean() - down.mean()))
    return abs(float(np.mean(gaps))) if gaps else 0.0
