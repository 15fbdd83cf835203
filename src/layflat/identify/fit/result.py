"""What a fit found, how sure it is, and how well it predicts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from layflat.identify.model import Model
from layflat.identify.unknown import Unknown

Array = NDArray[np.float64]

SURE = 0.2
"""A value is told by the log if its interval reaches less than this beyond it: of itself, or of half its range."""

ALIKE = 0.95
"""Correlation from which on two values are told only together."""


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval, SI.

    Args:
        unknown: what was looked for.
        value: best found.
        low: lower end of the interval.
        high: upper end.
        at_bound: whether the search ran into the end of its range.
        partner: what it can't be told apart from, if anything.
    """

    unknown: Unknown
    value: float
    low: float
    high: float
    at_bound: bool
    partner: str | None = None

    @property
    def told(self) -> bool:
        """Whether the log tells it."""
        if self.at_bound:
            return False
        if self.unknown.log:
            return 0.5 * np.log(self.high / self.low) < np.log1p(SURE) if self.low > 0.0 else False
        return self.high - self.low < SURE * (self.unknown.high - self.unknown.low)


@dataclass(frozen=True)
class Quality:
    """How well an output is predicted.

    Args:
        output: its name.
        unit: SI.
        log: which log.
        judged: over samples that were not fitted.
        samples: how many.
        rms: of the error, in `unit`.
        share: rms over the range of what was measured.
        fit: 1 - rms / standard deviation of what was measured.
        memory: correlation of an error with the one before it.
        bias: mean error, in `unit`.
    """

    output: str
    unit: str
    log: str
    judged: bool
    samples: int
    rms: float
    share: float
    fit: float
    memory: float
    bias: float


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    Args:
        model: what was fitted.
        estimates: of its unknowns, in order.
        simulated: all outputs with the best values, one after the other.
        converged: whether the search came to an end by itself.
        simulations: runs that it took.
    """

    model: Model
    estimates: tuple[Estimate, ...]
    simulated: Array
    converged: bool
    simulations: int

    @cached_property
    def values(self) -> Array:
        """Best values, (unknowns,) in SI."""
        return np.array([estimate.value for estimate in self.estimates])

    @property
    def trusted(self) -> bool:
        """Whether it converged with no value at a bound."""
        return self.converged and not any(estimate.at_bound for estimate in self.estimates)

    def of(self, path: str) -> Estimate:
        """The estimate of an unknown."""
        return next(estimate for estimate in self.estimates if estimate.unknown.path == path)

    def qualities(self) -> list[Quality]:
        """Of every output, over what was fitted and over what was not."""
        found = []
        for place, output in zip(self.model.slices, self.model.outputs, strict=True):
            for judged in (False, True):
                chosen = (output.fitted != judged) & np.isfinite(output.measured)
                if chosen.any():
                    measured = output.measured[chosen]
                    error = self.simulated[place][chosen] - measured
                    found.append(_quality(output.name, output.unit, output.log, judged, measured, error))
        return found


def _quality(name: str, unit: str, log: str, judged: bool, measured: Array, error: Array) -> Quality:
    rms, spread, reach = float(np.sqrt(np.mean(error**2))), float(np.std(measured)), float(np.ptp(measured))
    e = error - error.mean()
    power = float(e @ e)
    return Quality(
        name,
        unit,
        log,
        judged,
        len(error),
        rms,
        rms / reach if reach > 0.0 else np.inf,
        1.0 - rms / spread if spread > 0.0 else -np.inf,
        float(e[1:] @ e[:-1]) / power if power > 0.0 else 0.0,
        float(error.mean()),
    )
