"""Sensitivity indices from the table of a study whose samples are those of `saltelli` (saltelli2010)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RESAMPLES, ENDS = 200, (0.05, 0.95)
"""Of the bootstrap, and what share of them lies below the ends of an interval."""


@dataclass(frozen=True)
class Indices:
    """Sobol indices, one for each thing or group in order, with the ends of their intervals.

    Args:
        first: share of the variance that goes if this alone is known.
        total: share of the variance that stays if all but this is known.
        first_ends: (2, things)
        total_ends: (2, things)
    """

    first: Array
    total: Array
    first_ends: Array
    total_ends: Array


def sobol_indices(values: Array, things: int) -> Indices:
    """First and total indices of a result, by the estimators of saltelli2010, and 90 % intervals by bootstrap.

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
