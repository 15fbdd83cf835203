"""Logs of hysteresis curves of a joint or a rod: motion is given, effort is measured, predictions have errors."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.errors import InputError
from layflat.identify.benches.contract import Logs
from layflat.identify.benches.hysteresis.model import CurveModel
from layflat.identify.logs.checks.channels import without_spikes
from layflat.identify.model import FITTED, Flags, Output

SIZE = 0.03
"""How large an error of an effort matters, as a share of its range in the log where that is greatest.

It is the same for all logs, and well above the noise: what these laws leave over is mostly shape that they do not
model, as large in newtons at any pressure, and no log is to count more because its curve is lower.
"""

NOISES = 6.0  # a brake gives by so many standard deviations of the motion's noise


def signal(log: Dataset, name: str, where: str, joint: str = "") -> Array:
    """Signal of a log, of a joint where it has several, gaps interpolated, (samples,); raise InputError without it."""
    if name not in log:
        raise InputError(f"has no {name}", where=where, right=f"map a column to the signal {name}")
    found = _values(log, name, joint)
    known = np.isfinite(found)
    if not known.any():
        raise InputError(f"{name} has no numbers", where=where, right="leave the log out")
    time = log["time"].to_numpy()
    return np.asarray(np.interp(time, time[known], found[known]))


def moving(log: Dataset, name: str, where: str, joint: str = "") -> Array:
    """A motion, without spikes; raise InputError if it is not there, or never changes."""
    found = without_spikes(signal(log, name, where, joint))
    if not np.ptp(found) > 0.0:
        raise InputError(f"the {name} never changes", where=where, right="leave the log out")
    return found


def noise(values: Array) -> float:
    """Standard deviation of what differs from sample to sample, quantisation included: from second differences."""
    second = np.abs(np.diff(values, 2))
    return float(np.percentile(second, 90.0) / 1.645 / np.sqrt(6.0)) if len(second) else 0.0


def rate(time: Array, values: Array, window: float = 0.1) -> Array:
    """Rate of a measured motion, averaged over a window (s)."""
    from scipy.ndimage import uniform_filter1d  # noqa: PLC0415  # scipy takes long to import

    samples = max(1, round(window / float(np.median(np.diff(time)))))
    return np.asarray(np.gradient(uniform_filter1d(values, samples), time))


def first_of(output: Output) -> float:
    """The first measured sample that is a number."""
    return float(output.measured[np.isfinite(output.measured)][0])


def outputs(logs: Logs, validation: Logs | None, name: str, unit: str, joint: str = "") -> tuple[Output, ...]:
    """Measured efforts of all logs, those for validation last, on one scale; raise InputError if one never changes."""
    found = []
    share = np.inf if validation else FITTED  # of a log's time that is fitted
    given = [(share, where, log) for where, log in logs.items()]
    given += [(-np.inf, where, log) for where, log in (validation or {}).items()]
    for part, where, log in given:
        reach = float(np.ptp(signal(log, name, where, joint)))
        if reach == 0.0:
            raise InputError(f"{name} never changes", where=where, right="leave the log out")
        time = np.array(log["time"].to_numpy(), dtype=np.float64)
        fitted: Flags = time <= time[0] + part * (time[-1] - time[0])
        found.append(Output(name, unit, where, time, _values(log, name, joint), fitted, SIZE * reach))
    if not found:
        raise InputError("there is no log", where="logs", right="give one or more")
    scale = max(one.scale for one in found)
    return tuple(replace(one, scale=scale) for one in found)


def _values(log: Dataset, name: str, joint: str) -> Array:
    values = log[name].sel(joint=joint) if "joint" in log[name].dims else log[name]
    return np.array(values.to_numpy(), dtype=np.float64)


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
    """Return the way from each turning point on, (samples,): 1, -1, or 0 at first; noise does not turn it."""
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
