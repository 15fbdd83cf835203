"""Residuals of a model, and how they change with every unknown, from one simulation of all candidates."""

import numpy as np

from layflat.arrays import Array
from layflat.identify.model import Model

STEP, WIDEST = 1e-3, 0.2  # half the width of a difference, least and greatest, in shares of the way between the bounds
NOTICED = 2.0  # a difference is as wide as it takes to change the residuals by so much in all, within these limits

PRIOR_WIDTH = 0.5
"""Standard deviation of the prior of an unknown, as a share of the way between its bounds.

It is worth less than one good sample, and keeps what the log does not identify near the description. An unknown may
bring a prior of its own.
"""

EPSILON = float(np.finfo(np.float64).eps)  # times their number: what is smaller in differences is rounding

DIVERGED = 1e4  # what stands for a residual where a candidate diverged, in units of the scale


class Residuals:
    """Scaled residuals over what is fitted, with a row for the prior of each unknown."""

    def __init__(self, model: Model) -> None:
        self.model, self.scaled = model, model.shares
        self.begun = self.scaled.of(model.guess)
        known = [one.prior or (one.guess, PRIOR_WIDTH * (one.high - one.low)) for one in model.unknowns]
        own = np.array([one.prior is not None for one in model.unknowns], dtype=bool)
        means, widths = np.array(known, dtype=np.float64).reshape(-1, 2).T
        reach = self.scaled.high - self.scaled.low
        self.prior = np.where(own, (means - self.scaled.low) / reach, self.begun)
        self.widths = np.where(own, widths / reach, PRIOR_WIDTH)
        self.scales = [output.scale for output in model.outputs]
        self.triangle = np.diag(1.0 / self.widths)  # of all that the last Jacobian says, priors included (QR)
        self.axes, self.strengths = np.eye(len(self.prior)), np.full(len(self.prior), np.inf)

    def data(self, shares: Array) -> Array:
        """Residuals of candidates without the rows of the prior, (candidates, fitted samples)."""
        used, lengths = self.model.used, [len(output.measured) for output in self.model.outputs]
        found = self.model.simulate(self.scaled.values(shares))[:, used]
        error = (found - self.model.measured[used]) / np.repeat(self.scales, lengths)[used]
        return np.asarray(np.where(np.isfinite(error), error, DIVERGED), dtype=np.float64)

    def __call__(self, shares: Array) -> Array:
        """Residuals of one candidate."""
        return np.concatenate([self.data(shares[None])[0], self.prior_rows(shares)])

    def prior_rows(self, shares: Array) -> Array:
        """The rows of the prior."""
        return np.asarray((shares - self.prior) / self.widths)

    def costs(self, shares: Array) -> Array:
        """Half the sum of squares of each candidate."""
        data, known = self.data(shares), self.prior_rows(shares)
        return np.asarray(0.5 * (np.sum(data**2, axis=1) + np.sum(known**2, axis=1)))

    def data_jacobian(self, shares: Array) -> Array:
        """How the residuals of the data change, (fitted samples, unknowns).

        A joint that sticks and slips makes residuals rough. Differences are therefore taken along the principal axes of
        the last Jacobian, and the wider the less an axis changes: what the log hardly identifies then shows, and is
        not covered by roughness. They end at the bounds, where they are one-sided.
        """
        widths = np.clip(NOTICED / self.strengths, STEP, WIDEST)
        up, down = (_within(shares, way * self.axes, widths) for way in (1.0, -1.0))
        blocked = np.abs(up - down).max(axis=1) < 0.1 * STEP
        up[blocked], down[blocked] = (
            np.clip(shares + way * STEP * self.axes[blocked], 0.0, 1.0) for way in (1.0, -1.0)
        )
        found = self.data(np.vstack([up, down]))
        ways = np.linalg.pinv(up - down, len(up) * EPSILON)
        jacobian = np.asarray((ways @ (found[: len(up)] - found[len(up) :])).T)
        self.triangle = np.asarray(np.linalg.qr(np.vstack([jacobian, np.diag(1.0 / self.widths)]), mode="r"))
        _, self.strengths, self.axes = np.linalg.svd(self.triangle)
        return jacobian

    def jacobian(self, shares: Array) -> Array:
        """How the residuals change, (rows, unknowns)."""
        return np.vstack([self.data_jacobian(shares), np.diag(1.0 / self.widths)])


def _within(shares: Array, ways: Array, widths: Array) -> Array:
    """Points so far along each way (a row), or as far as the bounds let them."""
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(ways > 0.0, (1.0 - shares) / ways, np.where(ways < 0.0, -shares / ways, np.inf))
    return np.asarray(np.clip(shares + np.minimum(widths, room.min(axis=1))[:, None] * ways, 0.0, 1.0))
