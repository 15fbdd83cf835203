"""Unknowns as shares of the way between their bounds, evenly or by their logarithm: what the search turns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from layflat.errors import InputError
from layflat.identify.unknown import Unknown

Array = NDArray[np.float64]


class Scaled:
    """The way between values in SI and shares, 0 at the lower bound and 1 at the upper.

    Raises:
        InputError: bounds that leave no room, or a guess outside them.
    """

    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        for one in unknowns:
            if not (one.low < one.high and (one.low > 0.0 or not one.log)):
                raise InputError(f"{one.low:g} to {one.high:g} is no range", where=one.path, right="give low < high")
            if not one.low <= one.guess <= one.high:
                where = f"{one.path}: {one.guess:g} {one.unit}"
                raise InputError("lies outside what is searched", where=where, right=f"{one.low:g} to {one.high:g}")
        self.log = np.array([one.log for one in unknowns], dtype=bool)
        self.low = np.array([one.low for one in unknowns])
        self.high = np.array([one.high for one in unknowns])

    def shares(self, values: Array) -> Array:
        """Shares of values, (..., unknowns)."""
        with np.errstate(invalid="ignore", divide="ignore"):  # of those that are not logarithmic
            by_log = np.log(values / self.low) / np.log(self.high / self.low)
        return np.asarray(np.where(self.log, by_log, (values - self.low) / (self.high - self.low)))

    def values(self, shares: Array) -> Array:
        """Values of shares, (..., unknowns)."""
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            by_log = self.low * (self.high / self.low) ** shares
        found = np.where(self.log, by_log, self.low + shares * (self.high - self.low))
        return np.asarray(found, dtype=np.float64)
