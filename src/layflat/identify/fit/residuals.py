"""Residuals of a model, and how they change with every unknown, from one simulation of all candidates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from layflat.identify.fit.scaled import Scaled
from layflat.identify.model import Model

Array = NDArray[np.float64]

STEP = 1e-3
"""Half the width of a difference, as a share of the way between the bounds."""

VAGUENESS = 0.5
"""Standard deviation of what is known beforehand about an unknown, as a share of the way between its bounds.

It is worth less than one good sample, and keeps what the log does not tell near the description.
"""

LOST = 1e3
"""What stands for a residual where a candidate diverged, in units of the scale."""


class Residuals:
    """Scaled residuals over what is fitted, with a row for what is known beforehand of each unknown."""

    def __init__(self, model: Model) -> None:
        self.model, self.scaled = model, Scaled(model.unknowns)
        self.prior = self.scaled.shares(model.guess)
        self.scales = [output.scale for output in model.outputs]

    @property
    def scale(self) -> Array:
        """Of every fitted sample."""
        each = np.concatenate(
            [np.full(len(o.measured), s) for o, s in zip(self.model.outputs, self.scales, strict=True)]
        )
        return each[self.model.used]

    def data(self, shares: Array) -> Array:
        """Residuals of candidates without the rows of what is known beforehand, (candidates, fitted samples)."""
        used = self.model.used
        found = self.model.simulate(self.scaled.values(shares))[:, used]
        error = (found - self.model.measured[used]) / self.scale
        return np.asarray(np.where(np.isfinite(error), np.clip(error, -LOST, LOST), LOST))

    def __call__(self, shares: Array) -> Array:
        """Residuals of one candidate."""
        return np.concatenate([self.data(shares[None])[0], self.beforehand(shares)])

    def beforehand(self, shares: Array) -> Array:
        """The rows of what is known beforehand."""
        return np.asarray((shares - self.prior) / VAGUENESS)

    def costs(self, shares: Array) -> Array:
        """Half the sum of squares of each candidate."""
        return np.array([0.5 * (r @ r) for r in self.data(shares)]) + 0.5 * np.sum(self.beforehand(shares) ** 2, axis=1)

    def data_jacobian(self, shares: Array) -> Array:
        """How the residuals of the data change, (fitted samples, unknowns); differences across bounds are one-sided."""
        n = len(shares)
        up, down = np.minimum(shares + STEP, 1.0), np.maximum(shares - STEP, 0.0)
        candidates = np.tile(shares, (2 * n, 1))
        candidates[np.arange(n), np.arange(n)] = up
        candidates[n + np.arange(n), np.arange(n)] = down
        found = self.data(candidates)
        return np.asarray(((found[:n] - found[n:]) / (up - down)[:, None]).T)

    def jacobian(self, shares: Array) -> Array:
        """How the residuals change, (rows, unknowns)."""
        return np.vstack([self.data_jacobian(shares), np.eye(len(shares)) / VAGUENESS])
