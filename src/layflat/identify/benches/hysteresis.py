"""Hysteresis curves of a joint or a rod: their models' common parts, and signals read from their logs.

Motion is the input, effort (a torque or a force) is measured, elements slip one after the other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Generic, TypeVar

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description import Part
from layflat.description.change import changed_all, value_at
from layflat.errors import InputError
from layflat.identify.benches import Logs, insert_columns
from layflat.identify.logs.checks.channels import median_filter
from layflat.identify.model import FITTED_FRACTION, Flags, Model, ModelOutput, Unknown

Described = TypeVar("Described", bound=Part)

MIN_DEFLECTION_RATIO, MAX_DEFLECTION_RATIO = 1e-6, 2.0
"""Deflection after which an element slips, over the longest travel in the logs: Coulomb friction below, a spring above.

The lower bound is far below what any log resolves, so that friction which slips at once does not hit it.
"""

WEIGHT_DECIMALS = 6  # of weights in a description
FINE_REVERSALS = "reversals, sampled finely where the motion reverses"  # the excitation that identifies elements


class CurveModel(Model, Generic[Described]):
    """Model of the efforts in logs of hysteresis curves."""

    origin: Described  # description with the start of the search, and the values that are held
    losses: str  # path of the table with the deflections and weights of the elements
    motions: tuple[Array, ...]  # angle (rad) or position (m) of every log

    def describe_candidates(self, values: Array) -> Described:
        """Return the description, not validated, with an array of one item per candidate in place of each unknown."""
        return insert_columns(self.origin, self._described_columns(self.columns(values)))

    def describe(self, values: Array) -> Described:
        """Return the validated description with values of the unknowns (SI) in their places, weights rounded."""
        columns = self._described_columns({path: float(value) for path, value in self.columns(values).items()})
        if self._weights in columns:
            columns[self._weights] = round_weights(np.array(columns[self._weights]))
        return changed_all(self.origin, columns)

    def described_values(self, values: Array) -> dict[str, float]:
        """Return values (SI) by path, without nuisances: rounded weights of the elements in place of their split."""
        described, columns = self.describe(values), self._described_columns(self.columns(values))
        weights = [f"{self._weights}.{j}" for j in range(len(columns.pop(self._weights, ())))]
        return {path: float(value_at(described, path)) for path in (*columns, *weights)}

    @property
    def _weights(self) -> str:
        return f"{self.losses}.weights"

    def _described_columns(self, columns: Mapping[str, Any]) -> dict[str, Any]:
        """Return numbers or arrays by the description's paths: weights in place of their split, and no nuisances."""
        paths = [unknown.path for unknown in self.unknowns if not unknown.nuisance]
        described = {path: columns[path] for path in paths if ".split." not in path}
        split = [columns[path] for path in paths if ".split." in path]
        if split:
            described[self._weights] = tuple(np.moveaxis(weights_from_split(np.stack(split, axis=-1)), -1, 0))
        return described


def bounded_unknown(
    path: str,
    unit: str,
    guess: float,
    bounds: tuple[float, float],
    excitation: str,
    *,
    log: bool = False,
    floor: bool = False,
    ceiling: bool = False,
) -> Unknown:
    """Return an unknown with bounds that come from the logs; its guess is clipped to them.

    Args:
        path: path where it stands in the description.
        unit: SI, for tables.
        guess: described value.
        bounds: lower and upper one.
        excitation: what a log has to contain to identify it.
        log: whether the search is logarithmic.
        floor: whether the lower bound is physical.
        ceiling: whether the upper bound is physical.
    """
    inside = float(np.clip(guess, *bounds))
    return Unknown(path, unit, inside, *bounds, log=log, excitation=excitation, floor=floor, ceiling=ceiling)


def element_unknowns(
    where: str, unit: str, deflections: Sequence[float], weights: Sequence[float], travel: float
) -> list[Unknown]:
    """Return the deflections of elements, and the split of the friction among them, as unknowns.

    Args:
        where: path of the table that describes the elements.
        unit: unit of the motion.
        deflections: described ones, in `unit`.
        weights: described ones; searched as their split, see `weights_from_split`.
        travel: longest travel in any log, in `unit`; bounds the deflections.
    """
    bounds = MIN_DEFLECTION_RATIO * travel, MAX_DEFLECTION_RATIO * travel
    split = split_from_weights(np.array(weights))
    return [
        *(
            bounded_unknown(f"{where}.deflections.{j}", unit, deflection, bounds, FINE_REVERSALS, log=True)
            for j, deflection in enumerate(deflections)
        ),
        *(
            bounded_unknown(f"{where}.split.{j}", "1", float(part), (0.0, 1.0), FINE_REVERSALS)
            for j, part in enumerate(split)
        ),
    ]


def weights_from_split(split: Array) -> Array:
    """Return weights that add up to 1, (..., n + 1), from each element's fraction of the remainder, (..., n)."""
    remainder = np.cumprod(1.0 - split, axis=-1)
    ones = np.ones((*split.shape[:-1], 1))
    return np.asarray(np.concatenate([split, ones], axis=-1) * np.concatenate([ones, remainder], axis=-1))


def split_from_weights(weights: Array) -> Array:
    """Return each element's fraction of the remainder, but for the last: inverse of `weights_from_split`, (n,).

    Where nothing remains, the fraction is 0.5.
    """
    remainder = 1.0 - np.concatenate([[0.0], np.cumsum(weights)[:-1]])
    pairs = zip(weights[:-1], remainder[:-1], strict=True)
    return np.asarray([weight / rest if rest > 0.0 else 0.5 for weight, rest in pairs])


def round_weights(weights: Array) -> tuple[float, ...]:
    """Return weights with the decimals of a file that still add up to 1: the largest takes the difference."""
    decimals = np.round(weights, WEIGHT_DECIMALS)
    largest = int(np.argmax(decimals))
    decimals[largest] = round(1.0 - float(np.delete(decimals, largest).sum()), WEIGHT_DECIMALS)
    return tuple(float(weight) for weight in decimals)


EFFORT_ERROR_RATIO = 0.03
"""Scale of an effort's error, over its range in the log where that is greatest.

It is the same for all logs, and well above the noise: residuals of these laws are mostly a shape that they do not
model, as large in newtons at any pressure, and no log is to count more because its curve is lower.
"""

SLIP_NOISE_RATIO = 6.0  # rotation after which a brake slips, in standard deviations of the motion's noise


def read_signal(log: Dataset, name: str, where: str, joint: str = "") -> Array:
    """Return a signal of a log, (samples,): gaps interpolated, the first and last number held at the ends.

    Args:
        log: data set over `time`.
        name: name of the signal.
        where: name of the log, for messages.
        joint: joint of the signal, where there is one of each.

    Raises:
        InputError: the log does not have it, or it has no numbers.
    """
    if name not in log:
        raise InputError(f"has no {name}", where=where, right=f"map a column to the signal {name}")
    values = _values(log, name, joint)
    finite = np.isfinite(values)
    if not finite.any():
        raise InputError(f"{name} has no numbers", where=where, right="leave the log out")
    time = log["time"].to_numpy()
    return np.asarray(np.interp(time, time[finite], values[finite]))


def read_moving_signal(log: Dataset, name: str, where: str, joint: str = "") -> Array:
    """Return a motion with its gaps interpolated and spikes of one sample removed, (samples,).

    Args:
        log: data set over `time`.
        name: name of the signal.
        where: name of the log, for messages.
        joint: joint of the signal, where there is one of each.

    Raises:
        InputError: the log does not have it, it has no numbers, or it never changes.
    """
    values = median_filter(read_signal(log, name, where, joint))
    if not np.ptp(values) > 0.0:
        raise InputError(f"the {name} never changes", where=where, right="leave the log out")
    return values


def noise_level(values: Array) -> float:
    """Return the standard deviation of noise from sample to sample, quantisation included, by second differences."""
    second = np.abs(np.diff(values, 2))
    return float(np.percentile(second, 90.0) / 1.645 / np.sqrt(6.0)) if len(second) else 0.0


def smoothed_rate(time: Array, values: Array, window: float = 0.1) -> Array:
    """Return the rate of a measured motion, rad/s or m/s, averaged over a window.

    Args:
        time: s, (samples,).
        values: rad or m, (samples,).
        window: s.
    """
    from scipy.ndimage import uniform_filter1d  # noqa: PLC0415  # scipy takes long to import

    samples = max(1, round(window / float(np.median(np.diff(time)))))
    return np.asarray(np.gradient(uniform_filter1d(values, samples), time))


def first_sample(output: ModelOutput) -> float:
    """Return the first measured sample that is a number."""
    return float(output.measured[np.isfinite(output.measured)][0])


def effort_outputs(
    logs: Logs, validation: Logs | None, name: str, unit: str, joint: str = ""
) -> tuple[ModelOutput, ...]:
    """Return the measured efforts of all logs, those for validation last, as model outputs with a common scale.

    The scale is `EFFORT_ERROR_RATIO` times the greatest peak-to-peak range of all logs, so that each counts with one
    absolute error.

    Args:
        logs: logs to be fitted: all of their time, or the default fraction where there is no log for validation.
        validation: logs that are only predicted.
        name: name of the signal.
        unit: SI unit of the signal.
        joint: joint of the signal, where there is one of each.

    Raises:
        InputError: there is no log, or one lacks the effort, has no numbers of it, or its effort never changes.
    """
    outputs = []
    fraction = np.inf if validation else FITTED_FRACTION
    cases = [(fraction, where, log) for where, log in logs.items()]
    cases += [(-np.inf, where, log) for where, log in (validation or {}).items()]
    for fitted_part, where, log in cases:
        span = float(np.ptp(read_signal(log, name, where, joint)))
        if span == 0.0:
            raise InputError(f"{name} never changes", where=where, right="leave the log out")
        time = np.array(log["time"].to_numpy(), dtype=np.float64)
        fitted: Flags = time <= time[0] + fitted_part * (time[-1] - time[0])
        outputs.append(
            ModelOutput(name, unit, where, time, _values(log, name, joint), fitted, EFFORT_ERROR_RATIO * span)
        )
    if not outputs:
        raise InputError("there is no log", where="logs", right="give one or more")
    scale = max(output.scale for output in outputs)
    return tuple(replace(output, scale=scale) for output in outputs)


def _values(log: Dataset, name: str, joint: str) -> Array:
    """Return the samples of a joint's signal, or of one that all joints share, gaps as NaN, (samples,)."""
    values = log[name].sel(joint=joint) if "joint" in log[name].dims else log[name]
    return np.array(values.to_numpy(), dtype=np.float64)


REVERSAL_RATIO = 0.05  # a motion has reversed once it has come back by this fraction of its range
HEIGHT_RANGE_RATIO, HEIGHT_BINS = 0.8, 20  # middle part of the range over which a height is averaged, and its bins


@dataclass(frozen=True)
class CurveError:
    """Error of a predicted curve, relative to its height."""

    log: str  # name of the log
    validation: bool  # whether none of it was fitted
    height: float  # of the measured curve (see `loop_height`), N or N m
    raw: float  # rms of the error, over the height; inf without a height, as the next
    friction: float  # standard deviation of the error, over the height: the part that friction alone misses


def curve_errors(model: CurveModel[Any], simulated: Array) -> list[CurveError]:
    """Return the errors of all logs of a fitted model.

    Args:
        model: model that was fitted.
        simulated: all outputs with the fitted values, one after the other, as in `Fit.simulated`.
    """
    errors = []
    for rows, output, motion in zip(model.slices, model.outputs, model.motions, strict=True):
        height = loop_height(motion, output.measured)
        error = (simulated[rows] - output.measured)[np.isfinite(output.measured)]
        rms, deviation = float(np.sqrt(np.mean(error**2))), float(np.std(error))
        raw, friction = (rms / height, deviation / height) if height else (inf, inf)
        errors.append(CurveError(output.log, not output.fitted.any(), height, raw, friction))
    return errors


def motion_directions(motion: Array) -> Array:
    """Return the direction of motion from each turning point on, (samples,): 1, -1, or 0 before the first one.

    A reversal counts from `REVERSAL_RATIO` of the range on, so that noise is none.
    """
    play = REVERSAL_RATIO * float(np.ptp(motion))
    directions = np.zeros(len(motion))
    low, high, direction = 0, 0, 0.0
    for i, x in enumerate(motion.tolist()):
        high = i if x > motion[high] else high
        low = i if x < motion[low] else low
        if direction <= 0.0 and x > motion[low] + play:
            direction, high = 1.0, i
            directions[low : i + 1] = direction
        elif direction >= 0.0 and x < motion[high] - play:
            direction, low = -1.0, i
            directions[high : i + 1] = direction
        directions[i] = direction
    return directions


def loop_height(motion: Array, effort: Array) -> float:
    """Return the mean effort of forward less that of backward motion, over the middle of the range; never negative.

    The middle 80 % of the range are divided into 20 bins. In each the mean of all samples of backward motion is
    subtracted from the mean of those of forward motion; the height is the size of the mean over all bins with both, 0
    without such a bin.

    Args:
        motion: angle or position, (samples,).
        effort: torque or force; samples that are no numbers are left out.
    """
    direction = motion_directions(motion)
    low, span = float(motion.min()), float(np.ptp(motion))
    edges = low + span * np.linspace(0.5 - HEIGHT_RANGE_RATIO / 2, 0.5 + HEIGHT_RANGE_RATIO / 2, HEIGHT_BINS + 1)
    bins = np.digitize(motion, edges)
    gaps = []
    for k in range(1, HEIGHT_BINS + 1):
        inside = (bins == k) & np.isfinite(effort)
        forward, backward = effort[inside & (direction > 0)], effort[inside & (direction < 0)]
        if len(forward) and len(backward):
            gaps.append(float(forward.mean() - backward.mean()))
    return abs(float(np.mean(gaps))) if gaps else 0.0
