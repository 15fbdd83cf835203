"""How well an output is predicted, and whether its errors still hold anything that a better model would explain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.identify.model import Array, Output

LAGS = 25
"""Lags at which errors are compared with themselves, and with the input."""

BAND = 1.959964
"""What stays within so many over the root of the number of samples is chance, in 95 of 100 lags."""


@dataclass(frozen=True)
class Quality:
    """How well an output is predicted.

    Args:
        output: its name.
        unit: SI.
        log: which log.
        validation: over samples that were not fitted.
        samples: how many.
        rms: of the error, in `unit`.
        bias: mean error, in `unit`.
        share: rms over the range of what was measured.
        fit: 1 - rms / standard deviation of what was measured.
        white: share of the lags at which errors resemble themselves no more than chance; 0.95 for a perfect model.
        driven: greatest correlation of the error with the input, at any lag; None where no input is known.
    """

    output: str
    unit: str
    log: str
    validation: bool
    samples: int
    rms: float
    bias: float
    share: float
    fit: float
    white: float
    driven: float | None


def quality(output: Output, chosen: NDArray[np.bool_], simulated: Array, *, validation: bool) -> Quality:
    """Of the chosen samples of an output."""
    measured, error = output.measured[chosen], simulated[chosen] - output.measured[chosen]
    rms, spread, reach = float(np.sqrt(np.mean(error**2))), float(np.std(measured)), float(np.ptp(measured))
    alike = [abs(_correlation(error[lag:], error[:-lag])) for lag in range(1, min(LAGS, len(error) - 2) + 1)]
    return Quality(
        output.name,
        output.unit,
        output.log,
        validation,
        len(error),
        rms,
        float(error.mean()),
        rms / reach if reach > 0.0 else np.inf,
        1.0 - rms / spread if spread > 0.0 else -np.inf,
        float(np.mean(np.array(alike) < BAND / np.sqrt(len(error)))) if alike else 1.0,
        None if output.driven_by is None else _driven(error, output.driven_by[chosen]),
    )


def _driven(error: Array, given: Array) -> float:
    lags = range(min(LAGS, len(error) - 2))
    return max((abs(_correlation(error[lag:], given[: len(given) - lag])) for lag in lags), default=0.0)


def _correlation(a: Array, b: Array) -> float:
    a, b = a - a.mean(), b - b.mean()
    power = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / power if power > 0.0 else 0.0
