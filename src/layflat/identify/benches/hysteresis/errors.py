"""How well hysteresis curves are predicted, beside how high they are: one definition for joints and rods."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.identify.benches.hysteresis.model import CurveModel

PLAY = 0.05  # the way has turned once the motion has come back by this share of its range
MIDDLE, BINS = 0.8, 20  # share of the range in which a height is taken, and into how many parts it is divided


@dataclass(frozen=True)
class LoopError:
    """Error of a predicted curve, over its height."""

    log: str  # which log
    validation: bool  # whether none of it was fitted
    height: float  # of the measured curve (see `loop_height`), N or N m
    raw: float  # rms of the error, as a share of the height
    friction: float  # the same with the log's mean error taken away: what friction alone is missed by


def loop_errors(model: CurveModel[Any], simulated: Array) -> list[LoopError]:
    """Errors of all logs of a fitted model.

    Args:
        model: what was fitted.
        simulated: all outputs with the values found, one after the other, as in `Fit.simulated`.
    """
    found = []
    for place, output, motion in zip(model.slices, model.outputs, model.motions, strict=True):
        height = loop_height(motion, output.measured)
        error = (simulated[place] - output.measured)[np.isfinite(output.measured)]
        rms, spread = float(np.sqrt(np.mean(error**2))), float(np.std(error))
        found.append(LoopError(output.log, not output.fitted.any(), height, rms / height, spread / height))
    return found


def ways(motion: Array) -> Array:
    """Which way a motion goes from each turning point on, (samples,): 1, -1, or 0 at first; noise does not turn it."""
    play = PLAY * float(np.ptp(motion))
    found = np.zeros(len(motion))
    low, high, way = 0, 0, 0.0
    for i, x in enumerate(motion.tolist()):
        high = i if x > motion[high] else high
        low = i if x < motion[low] else low
        if way <= 0.0 and x > motion[low] + play:
            way, high = 1.0, i
            found[low : i + 1] = way
        elif way >= 0.0 and x < motion[high] - play:
            way, low = -1.0, i
            found[high : i + 1] = way
        found[i] = way
    return found


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
