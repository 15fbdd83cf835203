"""What a fit found, how sure it is, and how well it predicts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from layflat.identify.fit.quality import Quality, quality
from layflat.identify.model import Model
from layflat.identify.unknown import Unknown

Array = NDArray[np.float64]

SURE = 0.2
"""A parameter is identified if its interval reaches less than this beyond it: of itself, or of half its range."""

ALIKE = 0.95
"""Correlation from which on two parameters are identified only together."""

MISPREDICTED = 0.25
"""A prediction that misses by more (rms, as a share of the range) is none: the search ended in a wrong minimum."""


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval, SI.

    Args:
        unknown: what was looked for.
        value: best found.
        low: lower end of the interval.
        high: upper end.
        at_bound: whether it hit its bound.
        partner: the parameter that it can't be separated from, if any.
    """

    unknown: Unknown
    value: float
    low: float
    high: float
    at_bound: bool
    partner: str | None = None

    @property
    def identified(self) -> bool:
        """Whether the log identifies it."""
        if self.at_bound:
            return False
        if self.unknown.log:
            return 0.5 * np.log(self.high / self.low) < np.log1p(SURE) if self.low > 0.0 else False
        return self.high - self.low < SURE * (self.unknown.high - self.unknown.low)


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    Args:
        model: what was fitted.
        estimates: of its unknowns, in order.
        simulated: all outputs with the best values, one after the other.
        converged: whether the search converged.
        simulations: runs that it took.
        partial: whether the user stopped it.
    """

    model: Model
    estimates: tuple[Estimate, ...]
    simulated: Array
    converged: bool
    simulations: int
    partial: bool = False

    @cached_property
    def values(self) -> Array:
        """Best values, (unknowns,) in SI."""
        return np.array([estimate.value for estimate in self.estimates])

    @property
    def trusted(self) -> bool:
        """Whether it converged with no value at a bound, and predicts."""
        return (
            self.converged and not any(estimate.at_bound for estimate in self.estimates) and self.mispredicted is None
        )

    @cached_property
    def mispredicted(self) -> Quality | None:
        """The worst prediction of what is fitted elsewhere, if it misses by more than `MISPREDICTED`."""
        found = self.qualities()
        fitted = {one.output for one in found if not one.validation}
        validation = [one for one in found if one.validation and one.output in fitted]
        worst = max(validation, key=lambda one: one.share, default=None)
        return worst if worst is not None and worst.share > MISPREDICTED else None

    def of(self, path: str) -> Estimate:
        """The estimate of an unknown."""
        return next(estimate for estimate in self.estimates if estimate.unknown.path == path)

    def qualities(self) -> list[Quality]:
        """Of every output, over the fitted samples and over those for validation."""
        found = []
        for place, output in zip(self.model.slices, self.model.outputs, strict=True):
            for validation in (False, True):
                chosen = (output.fitted != validation) & np.isfinite(output.measured)
                if chosen.any():
                    found.append(quality(output, chosen, self.simulated[place], validation=validation))
        return found
