"""Values of what is sought as shares of the ways between their bounds: a search takes all of them alike."""

from collections.abc import Sequence

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.unknown import Unknown

NEAR = 1e-6  # share by which it is seen how shares change by others


class Shares:
    """Values in SI as shares, 0 at the lower bound and 1 at the upper; raise InputError if a guess lies outside."""

    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        for one in unknowns:
            if not (one.low < one.high and (one.low > 0.0 or not one.log)):
                raise InputError(f"{one.low:g} to {one.high:g} is not a range", where=one.path, right="give low < high")
            if not one.low <= one.guess <= one.high:
                where = f"{one.path}: {one.guess:g} {one.unit}"
                raise InputError("lies outside what is searched", where=where, right=f"{one.low:g} to {one.high:g}")
        self.own: Shares = self  # shares of the unknowns themselves, where these are of others
        self.log = np.array([one.log for one in unknowns], dtype=bool)
        self.low = np.array([one.low for one in unknowns])
        self.high = np.array([one.high for one in unknowns])

    def of(self, values: Array) -> Array:
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

    def as_own(self, shares: Array) -> tuple[Array, Array]:
        """Shares as those of the unknowns themselves, and how much these (rows) change by them (columns)."""
        if self.own is self:
            return shares, np.eye(len(shares))
        away = NEAR * np.eye(len(shares))
        up, down = (self.own.of(self.values(shares + way * away)) for way in (1.0, -1.0))
        return self.own.of(self.values(shares)), np.asarray((up - down).T / (2.0 * NEAR))
