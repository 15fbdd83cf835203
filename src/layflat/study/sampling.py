"""Samples of what varies, and the runs that they make: each sample in every scenario with every seed of the noise."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.study.description import StudyFile
from layflat.study.varied import Varied, groups

Array = NDArray[np.float64]


def samples(varied: Sequence[Varied], file: StudyFile) -> dict[str, Array]:
    """One number a sample (SI) by the path that varies; the same for the same file."""
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
    """Points in the unit cube for sensitivity indices (saltelli2010): blocks A, B, one AB for each dimension and group.

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
    """Rows `first` to before `last` of a study: variant by variant, sample by sample, then scenario, then seed.

    Args:
        drawn: one number a sample by what varies.
        count: of samples.
        variants: how many.
        seeds: first seed of the noise of every scenario.
        noise_seeds: how many, one after the other.
        first: row.
        last: row after the last one.

    Returns:
        One number a run by what varies; "variant", "sample", "scenario" (its number) and "seed" among them.
    """
    shape = (variants, count, len(seeds), noise_seeds)
    places: Any = np.unravel_index(np.arange(first, last), shape)
    variant, sample, scenario, noise = places
    own: dict[str, Array] = {"variant": variant, "sample": sample, "scenario": scenario}
    own["seed"] = np.asarray(seeds)[scenario] + noise
    return own | {path: values[sample] for path, values in drawn.items()}
