"""Samples of what varies, and the runs that they make: each sample in every scenario with every seed of the noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.study.description import StudyFile
from layflat.study.varied import Varied

Array = NDArray[np.float64]


def samples(varied: Sequence[Varied], file: StudyFile) -> dict[str, Array]:
    """One number a sample (SI) by the path that varies; the same for the same file."""
    if file.sampling == "grid":
        axes = np.meshgrid(*(one.grid() for one in varied), indexing="ij")
        return {one.path: axis.ravel() for one, axis in zip(varied, axes, strict=True)}
    from scipy.stats import qmc  # noqa: PLC0415  # takes long to import

    engine: Any = qmc.Sobol if file.sampling == "sobol" else qmc.LatinHypercube
    shares = engine(len(varied), rng=file.seed).random(file.runs)
    return {one.path: one.at(shares[:, i]) for i, one in enumerate(varied)}


def rows(drawn: dict[str, Array], seeds: Sequence[int], noise_seeds: int, first: int, last: int) -> dict[str, Array]:
    """Rows `first` to before `last` of a study: sample by sample, in these scenario by scenario, in these seed by seed.

    Args:
        drawn: one number a sample by what varies.
        seeds: first seed of the noise of every scenario.
        noise_seeds: how many, one after the other.
        first: row.
        last: row after the last one.

    Returns:
        One number a run by what varies; "sample", "scenario" (its number) and "seed" among them.
    """
    number = np.arange(first, last)
    sample, within = np.divmod(number, len(seeds) * noise_seeds)
    scenario, noise = np.divmod(within, noise_seeds)
    own = {"sample": sample, "scenario": scenario, "seed": np.asarray(seeds)[scenario] + noise}
    return own | {path: values[sample] for path, values in drawn.items()}
