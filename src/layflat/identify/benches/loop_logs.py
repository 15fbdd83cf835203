"""What logs of loops have in common, of a joint or of a rod: motion given, effort measured."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from layflat.errors import InputError
from layflat.identify.model import FITTED, Array, Flags, Output
from layflat.identify.unknown import Unknown

if TYPE_CHECKING:
    import xarray

Logs: TypeAlias = "Mapping[str, xarray.Dataset]"

SIZE = 0.03
"""How large an error of an effort matters, as a share of its range in the log where that is greatest.

It is the same for all logs, and well above the noise: what a law of loops leaves over is mostly shape that it does not
know, as large in newtons at any pressure, and no log is to count more because its loop is lower.
"""

LEAST, MOST = 1e-6, 2.0
"""An element slips after so much of the longest travel in the logs: it is Coulomb friction below, a spring above.

The least is far below what any log tells, so that friction which slips at once does not end at a bound.
"""

DECIMALS = 6
"""Of weights in a description."""

NOISES = 6.0
"""A brake gives by so many standard deviations of the motion's noise."""


def signal(log: xarray.Dataset, name: str, where: str, joint: str = "") -> Array:
    """A signal of a log, of a joint where it has several, without gaps; (samples,).

    Raises:
        InputError: it is not there.
    """
    if name not in log:
        raise InputError(f"has no {name}", where=where, right=f"map a column to the signal {name}")
    values = log[name].sel(joint=joint) if "joint" in log[name].dims else log[name]
    found = np.array(values.to_numpy(), dtype=np.float64)
    known = np.isfinite(found)
    if not known.any():
        raise InputError(f"{name} has no numbers", where=where, right="leave the log out")
    time = log["time"].to_numpy()
    return np.asarray(np.interp(time, time[known], found[known]))


def without_spikes(values: Array) -> Array:
    """Every sample replaced by the median of itself and its neighbours.

    A way up or down stays as it is, and single samples far off go: an element that slips would take a spike for a way
    to and fro, and forget where the motion turned.
    """
    padded = np.concatenate([values[:1], values, values[-1:]])
    return np.asarray(np.median(np.stack([padded[:-2], padded[1:-1], padded[2:]]), axis=0))


def noise(values: Array) -> float:
    """Standard deviation of what differs from sample to sample, counts included: from second differences."""
    second = np.abs(np.diff(values, 2))
    return float(np.percentile(second, 90.0) / 1.645 / np.sqrt(6.0)) if len(second) else 0.0


def rate(time: Array, values: Array, window: float = 0.1) -> Array:
    """Rate of a measured motion, averaged over a window (s)."""
    from scipy.ndimage import uniform_filter1d  # noqa: PLC0415  # scipy takes long to import

    samples = max(1, round(window / float(np.median(np.diff(time)))))
    return np.asarray(np.gradient(uniform_filter1d(values, samples), time))


def first_of(values: Array) -> float:
    """The first sample that is a number."""
    return float(values[np.isfinite(values)][0])


def output(log: xarray.Dataset, name: str, unit: str, where: str, *, whole: bool | None, joint: str = "") -> Output:
    """The measured effort of a log.

    Args:
        log: its signals.
        name: of the effort.
        unit: SI.
        where: name of the log.
        whole: whether all of it is fitted, or its first two thirds; None if it is only predicted.
        joint: whose effort, in a log of several.
    """
    filled = signal(log, name, where, joint)
    values = log[name].sel(joint=joint) if "joint" in log[name].dims else log[name]
    time = np.array(log["time"].to_numpy(), dtype=np.float64)
    end = {None: -np.inf, True: np.inf, False: time[0] + FITTED * (time[-1] - time[0])}[whole]
    fitted: Flags = time <= end
    reach = float(np.ptp(filled))
    if reach == 0.0:
        raise InputError(f"{name} never changes", where=where, right="leave the log out")
    return Output(name, unit, where, time, np.array(values.to_numpy(), dtype=np.float64), fitted, SIZE * reach)


def outputs(logs: Logs, judged: Logs | None, name: str, unit: str, joint: str = "") -> tuple[Output, ...]:
    """The measured effort of all logs, those that are judged last, with errors that count alike."""
    whole = bool(judged)
    found = [output(log, name, unit, where, whole=whole, joint=joint) for where, log in logs.items()]
    found += [output(log, name, unit, where, whole=None, joint=joint) for where, log in (judged or {}).items()]
    if not found:
        raise InputError("there is no log", where="logs", right="give one or more")
    scale = max(one.scale for one in found)
    return tuple(replace(one, scale=scale) for one in found)


def of_range(path: str, unit: str, guess: float, low: float, high: float, told: str, *, log: bool = False) -> Unknown:
    """An unknown with bounds that come from the logs; the search begins at the guess as far as it lies inside."""
    return Unknown(path, unit, float(np.clip(guess, low, high)), low, high, log=log, excitation=told)


def check_blocks(blocks: Collection[str], known: Collection[str]) -> None:
    """Refuse a block that is none.

    Raises:
        InputError: naming it.
    """
    unknown = sorted(set(blocks) - set(known))
    if unknown:
        raise InputError(f"{unknown[0]!r} is no block", where="blocks", right=f"use {', '.join(known)}")


def elements(
    where: str, unit: str, deflections: Sequence[float], weights: Sequence[float], travel: float
) -> list[Unknown]:
    """Deflections of elements, and how they share the friction (see `shares_of`), as unknowns.

    Args:
        where: path of the table that they stand in.
        unit: of the motion.
        deflections: described.
        weights: described.
        travel: longest in all logs.
    """
    told = "reversals, sampled finely where the motion turns"
    low, high = LEAST * travel, MOST * travel
    found = [
        of_range(f"{where}.deflections.{j}", unit, d, low, high, told, log=True) for j, d in enumerate(deflections)
    ]
    split = split_of(np.array(weights))
    return found + [of_range(f"{where}.split.{j}", "1", float(part), 0.0, 1.0, told) for j, part in enumerate(split)]


def shares_of(split: Array) -> Array:
    """Weights that add up to 1, (..., n + 1), from what each element takes of what those before it leave, (..., n)."""
    left = np.cumprod(1.0 - split, axis=-1)
    one = np.ones((*split.shape[:-1], 1))
    return np.asarray(np.concatenate([split, one], axis=-1) * np.concatenate([one, left], axis=-1))


def rounded(weights: Array) -> tuple[float, ...]:
    """Weights with six decimals that still add up to 1, as they can stand in a file."""
    found = np.round(weights, DECIMALS)
    largest = int(np.argmax(found))
    found[largest] = round(1.0 - float(np.delete(found, largest).sum()), DECIMALS)
    return tuple(float(one) for one in found)


def split_of(weights: Array) -> Array:
    """What each element but the last takes of what those before it leave: the inverse of `shares_of`."""
    left = 1.0 - np.concatenate([[0.0], np.cumsum(weights)[:-1]])
    return np.asarray([w / rest if rest > 0.0 else 0.5 for w, rest in zip(weights[:-1], left[:-1], strict=True)])
