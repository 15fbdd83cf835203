"""Residuals with their Jacobian, and the uncertainty of fitted values from it and from a bootstrap over blocks of time.

| symbol | meaning |
|---|---|
| r, J | residuals at the optimum, their Jacobian by the unknowns |
| H_k, g_k | sum of J'J and of J'r over block k |
| P | inverse covariance of the prior: of independent unknowns with standard deviations `widths`, in shares |

White residuals of known size have the covariance (J'J + P)^-1. Measured ones are neither: quantisation at rest and what
a model leaves out stay the same for many samples. Blocks longer than this memory are drawn with replacement, and each
draw moves the optimum by one Gauss-Newton step, -(H + P)^-1 g, which needs no further simulation (kunsch1989).
"""

import numpy as np
from numpy.typing import NDArray

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
        """Return how the residuals of the data change, (fitted samples, unknowns).

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
        """Return how the residuals change, (rows, unknowns)."""
        return np.vstack([self.data_jacobian(shares), np.diag(1.0 / self.widths)])


def _within(shares: Array, ways: Array, widths: Array) -> Array:
    """Points so far along each way (a row), or as far as the bounds let them."""
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(ways > 0.0, (1.0 - shares) / ways, np.where(ways < 0.0, -shares / ways, np.inf))
    return np.asarray(np.clip(shares + np.minimum(widths, room.min(axis=1))[:, None] * ways, 0.0, 1.0))


DRAWS = 1000  # bootstrap samples
MOST_BLOCKS, LEAST_BLOCKS = 100, 20  # blocks in all logs together
MEMORIES = 5.0  # length of a block over the residuals' memory
NORMAL = 1.959964  # standard deviations in 95 %


def covariance(jacobian: Array, residuals: Array, widths: Array) -> Array:
    """Return the covariance of the shares for residuals as large as they are, but not below their scale."""
    size = max(1.0, float(residuals @ residuals) / max(len(residuals) - jacobian.shape[1], 1))
    return _inverse(jacobian.T @ jacobian / size, widths)


def bootstrap(jacobian: Array, residuals: Array, widths: Array, blocks: NDArray[np.int64], seed: int) -> Array:
    """Moves of the optimum, (draws, unknowns), from blocks (the number of each sample's) drawn with replacement."""
    count, n = int(blocks.max()) + 1, jacobian.shape[1]
    order = np.argsort(blocks, kind="stable")
    edges = np.searchsorted(blocks[order], np.arange(count + 1))
    H, g = np.empty((count, n, n)), np.empty((count, n))
    for k in range(count):
        rows = order[edges[k] : edges[k + 1]]
        H[k], g[k] = jacobian[rows].T @ jacobian[rows], jacobian[rows].T @ residuals[rows]
    # At the optimum the prior pulls as hard as all blocks together: spread over them.
    g -= g.mean(axis=0)
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), size=DRAWS)
    moves = np.empty((DRAWS, n))
    for i, times in enumerate(drawn):
        moves[i] = -_inverse(np.tensordot(times, H, 1), widths) @ (times @ g)
    return moves


def blocks_of(model: Model, residuals: Array) -> NDArray[np.int64]:
    """Number of the block of time of every fitted sample; outputs of a log share their blocks."""
    used, every = model.used, np.zeros(len(model.used))
    every[used] = residuals
    outputs = list(zip(model.slices, model.outputs, strict=True))
    parts = [(every[place][used[place]], output.time) for place, output in outputs]
    memory = max(_memory(part, float(np.median(np.diff(time)))) for part, time in parts if len(part) > 1)
    logs = list(dict.fromkeys(output.log for output in model.outputs))
    spans = {log: max(float(o.time[-1] - o.time[0]) for o in model.outputs if o.log == log) for log in logs}
    total = sum(spans.values())
    length = min(max(MEMORIES * memory, total / MOST_BLOCKS), total / LEAST_BLOCKS)
    numbers, first = np.empty(len(used), dtype=np.int64), 0
    for log in logs:
        for place, output in outputs:
            if output.log == log:
                numbers[place] = first + ((output.time - output.time[0]) / length).astype(np.int64)
        first += int(spans[log] / length) + 1
    return np.unique(numbers[used], return_inverse=True)[1]


def interval(shares: Array, spread: Array, moves: Array) -> tuple[Array, Array]:
    """Low and high ends of 95 % in shares: the wider of both ways, and no narrower than differences can see.

    A simulation that sticks and slips is rough over steps smaller than those of the Jacobian: nothing is known there.
    """
    half = np.maximum(NORMAL * np.sqrt(np.diag(spread)), STEP)
    low, high = np.percentile(moves, [2.5, 97.5], axis=0)
    return shares - np.maximum(half, -low), shares + np.maximum(half, high)


def is_told(residuals: Array, others: Array, blocks: NDArray[np.int64]) -> bool:
    """Return whether two sets of residuals, (samples,), differ in size by more than chance, from block to block."""
    differences = np.bincount(blocks, others**2 - residuals**2)
    chance = np.sqrt(len(differences)) * float(differences.std(ddof=1))
    return bool(abs(differences.sum()) > NORMAL * chance)


def _memory(residuals: Array, period: float) -> float:
    """Correlation time of residuals, s: until their autocorrelation falls below 1/e."""
    r = residuals - residuals.mean()
    n = len(r)
    if not np.any(r):
        return 0.0
    power = np.abs(np.fft.rfft(r, 2 * n)) ** 2
    alike = np.fft.irfft(power)[:n]
    below = np.flatnonzero(alike < alike[0] / np.e)
    return float(below[0] if len(below) else n) * period


def _inverse(H: Array, widths: Array) -> Array:
    """Inverse of what the data say, clipped to be positive, plus the prior."""
    # In units of the prior its own part is 1 in all directions.
    values, vectors = np.linalg.eigh(H * np.outer(widths, widths))
    known = (vectors / (np.maximum(values, 0.0) + 1.0)) @ vectors.T
    return np.asarray(known * np.outer(widths, widths), dtype=np.float64)
