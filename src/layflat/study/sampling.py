"""Samples of what varies, the runs that they make, and the sensitivity indices of what comes of these."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.study.description import StudyFile
from layflat.study.varied import Varied, groups

RESAMPLES, ENDS = 200, (0.05, 0.95)
"""Of the bootstrap of indices, and what share of them lies below the ends of an interval."""


def samples(varied: Sequence[Varied], file: StudyFile) -> dict[str, Array]:
    """Return one number a sample (SI) by the path that varies; the same for the same file."""
    if file.sampling == "grid":
        axes = np.meshgrid(*(one.grid() for one in varied), indexing="ij")
        return {one.path: axis.ravel() for one, axis in zip(varied, axes, strict=True)}
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    assert file.runs is not None
    if file.sampling == "saltelli":
        shares = saltelli(len(varied), file.runs, file.seed, groups(varied).values())
    else:
        engine: Any = qmc.Sobol if file.sampling == "sobol" else qmc.LatinHypercube
        shares = engine(len(varied), rng=file.seed).random(file.runs)
    return {one.path: one.at(shares[:, i]) for i, one in enumerate(varied)}


def saltelli(dimensions: int, runs: int, seed: int, groups: Iterable[Sequence[int]] = ()) -> Array:
    """Return points in the unit cube for sensitivity indices (saltelli2010): A, B, an AB a dimension and a group.

    A and B are independent; an AB is A with the columns of its dimension, or of its group, taken from B.

    Returns:
        ((2 + dimensions + groups) * runs, dimensions)
    """
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    both = qmc.Sobol(2 * dimensions, rng=seed).random(runs)
    a, b = both[:, :dimensions], both[:, dimensions:]
    taken = [*([i] for i in range(dimensions)), *groups]
    mixed = [np.where(np.isin(np.arange(dimensions), columns), b, a) for columns in taken]
    return np.concatenate([a, b, *mixed])


def rows(
    drawn: dict[str, Array], count: int, variants: int, seeds: Sequence[int], noise_seeds: int, first: int, last: int
) -> dict[str, Array]:
    """Return rows `first` to before `last` of a study: variant by variant, sample by sample, then scenario, then seed.

    Of what varies, `drawn` has a number for each of `count` samples. Each row has its own, and a "variant", a "sample",
    a "scenario" (their numbers) and a "seed", one of `noise_seeds` from that of the scenario in `seeds` on.
    """
    shape = (variants, count, len(seeds), noise_seeds)
    places: Any = np.unravel_index(np.arange(first, last), shape)
    variant, sample, scenario, noise = places
    own: dict[str, Array] = {"variant": variant, "sample": sample, "scenario": scenario}
    own["seed"] = np.asarray(seeds)[scenario] + noise
    return own | {path: values[sample] for path, values in drawn.items()}


@dataclass(frozen=True)
class Indices:
    """Sobol indices, one for each thing or group in order, with the ends of their intervals."""

    first: Array  # share of the variance that goes if this alone is known
    total: Array  # share of the variance that stays if all but this is known
    first_ends: Array  # (2, things)
    total_ends: Array  # (2, things)


def sobol_indices(values: Array, things: int) -> Indices:
    """Return first and total indices of a result, by the estimators of saltelli2010, and 90 % intervals by bootstrap.

    Args:
        values: the result at the points of `sampling.saltelli`, in their order.
        things: how many dimensions and groups there are.
    """
    blocks = values.reshape(things + 2, -1)
    runs = blocks.shape[1]
    rng = np.random.default_rng(0)
    again = np.array([_estimated(blocks[:, rng.integers(runs, size=runs)]) for _ in range(RESAMPLES)])
    ends = np.quantile(again, ENDS, axis=0)
    first, total = _estimated(blocks)
    return Indices(first, total, ends[:, 0], ends[:, 1])


def _estimated(blocks: Array) -> Array:
    """First and total indices, (2, things); zeros where nothing changes the result."""
    from scipy import stats  # noqa: PLC0415  # takes long to import

    if np.ptp(blocks) == 0.0:
        return np.zeros((2, len(blocks) - 2))
    functions: Any = {"f_A": blocks[:1], "f_B": blocks[1:2], "f_AB": blocks[2:, None, :]}
    found: Any = stats.sobol_indices(func=functions, n=blocks.shape[1])
    return np.array([np.ravel(found.first_order), np.ravel(found.total_order)])
