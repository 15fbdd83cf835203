"""Samples of the axes of a study, its rows, and sensitivity indices of the results."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.study.description import StudyFile
from layflat.study.varied import StudyAxis, group_axes

BOOTSTRAP_SAMPLES, INTERVAL_LEVELS = 200, (0.05, 0.95)
"""Number of resamples of the bootstrap of indices, and the quantiles at the ends of an interval."""


def draw_samples(varied: Sequence[StudyAxis], file: StudyFile) -> dict[str, Array]:
    """Return one value per sample (SI), by path; the same for the same file."""
    if file.sampling == "grid":
        axes = np.meshgrid(*(one.grid() for one in varied), indexing="ij")
        return {one.path: axis.ravel() for one, axis in zip(varied, axes, strict=True)}
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    assert file.runs is not None
    if file.sampling == "saltelli":
        shares = saltelli_points(len(varied), file.runs, file.seed, group_axes(varied).values())
    else:
        engine: Any = qmc.Sobol if file.sampling == "sobol" else qmc.LatinHypercube
        shares = engine(len(varied), rng=file.seed).random(file.runs)
    return {one.path: one.quantiles(shares[:, i]) for i, one in enumerate(varied)}


def saltelli_points(dimensions: int, runs: int, seed: int, groups: Iterable[Sequence[int]] = ()) -> Array:
    """Return points in the unit cube for sensitivity indices (saltelli2010): blocks A, B, and AB per axis and group.

    A and B are independent; an AB is A with the columns of its axis, or of its group, from B.

    Args:
        dimensions: number of axes.
        runs: points per block, a power of two.
        seed: seed of the Sobol sequence.
        groups: indices of the axes in each group.

    Returns:
        Points ((2 + dimensions + groups) * runs, dimensions).
    """
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    both = qmc.Sobol(2 * dimensions, rng=seed).random(runs)
    a, b = both[:, :dimensions], both[:, dimensions:]
    taken = [*([i] for i in range(dimensions)), *groups]
    mixed = [np.where(np.isin(np.arange(dimensions), columns), b, a) for columns in taken]
    return np.concatenate([a, b, *mixed])


def study_rows(
    drawn: dict[str, Array], count: int, variants: int, seeds: Sequence[int], noise_seeds: int, first: int, last: int
) -> dict[str, Array]:
    """Return a range of rows of a study, ordered by variant, sample, scenario and noise seed.

    Args:
        drawn: one value per sample, by path.
        count: number of samples.
        variants: number of variants.
        seeds: first noise seed of each scenario.
        noise_seeds: number of noise seeds.
        first: first row.
        last: row after the last one.

    Returns:
        One value per row, by path; and indices "variant", "sample" and "scenario", and "seed".
    """
    shape = (variants, count, len(seeds), noise_seeds)
    places: Any = np.unravel_index(np.arange(first, last), shape)
    variant, sample, scenario, noise = places
    columns: dict[str, Array] = {"variant": variant, "sample": sample, "scenario": scenario}
    columns["seed"] = np.asarray(seeds)[scenario] + noise
    return columns | {path: values[sample] for path, values in drawn.items()}


@dataclass(frozen=True)
class SobolIndices:
    """Sobol indices, one for each axis and group in order, with the ends of their intervals."""

    first: Array  # first-order: fraction of the variance that vanishes if this alone is fixed
    total: Array  # total: fraction of the variance that remains if all but this is fixed
    first_ends: Array  # (2, axes and groups)
    total_ends: Array  # (2, axes and groups)


def sobol_indices(values: Array, things: int) -> SobolIndices:
    """Return first and total indices of a result, by the estimators of saltelli2010, and 90 % intervals by bootstrap.

    Args:
        values: the result at the points of `saltelli_points`, in their order.
        things: number of axes and groups.
    """
    blocks = values.reshape(things + 2, -1)
    runs = blocks.shape[1]
    rng = np.random.default_rng(0)
    again = np.array([_estimate_indices(blocks[:, rng.integers(runs, size=runs)]) for _ in range(BOOTSTRAP_SAMPLES)])
    ends = np.quantile(again, INTERVAL_LEVELS, axis=0)
    first, total = _estimate_indices(blocks)
    return SobolIndices(first, total, ends[:, 0], ends[:, 1])


def _estimate_indices(blocks: Array) -> Array:
    """Return first and total indices, (2, axes and groups); zeros for a constant result."""
    from scipy import stats  # noqa: PLC0415  # takes long to import

    if np.ptp(blocks) == 0.0:
        return np.zeros((2, len(blocks) - 2))
    functions: Any = {"f_A": blocks[:1], "f_B": blocks[1:2], "f_AB": blocks[2:, None, :]}
    indices: Any = stats.sobol_indices(func=functions, n=blocks.shape[1])
    return np.array([np.ravel(indices.first_order), np.ravel(indices.total_order)])
