"""Residuals with their Jacobian, and the uncertainty of fitted values from it and from a bootstrap over blocks of time.

Vectors of unknowns are scaled: 0 at the lower bound, 1 at the upper one (`Scaling`).

| symbol | meaning |
|---|---|
| r, J | residuals at the optimum, their Jacobian by the scaled unknowns |
| H_k, g_k | sum of J'J and of J'r over block k |
| P | inverse covariance of the prior: of independent unknowns with standard deviations `widths`, scaled |

White residuals of known size have the covariance (J'J + P)^-1. Measured ones are neither: quantisation at rest and
effects that a model leaves out stay the same for many samples. Blocks longer than this correlation are drawn with
replacement, and each draw moves the optimum by one Gauss-Newton step, -(H + P)^-1 g, which needs no further simulation
(kunsch1989).
"""

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.model import Model

MIN_DIFFERENCE_STEP, MAX_DIFFERENCE_STEP = 1e-3, 0.2  # half the width of a difference quotient, scaled
TARGET_RESIDUAL_CHANGE = 2.0  # norm of the residuals' change for which a difference is made wide, within these limits

PRIOR_WIDTH = 0.5
"""Standard deviation of the prior of an unknown, as a fraction of the range between its bounds.

It is worth less than one good sample, and keeps unknowns that the log does not identify near the description. An
unknown may bring a prior of its own.
"""

EPSILON = float(np.finfo(np.float64).eps)  # times their number: differences below this are rounding errors

DIVERGED_RESIDUAL = 1e4  # residual of a candidate that diverged, in units of the output's scale


class Residuals:
    """Scaled residuals of the fitted samples, followed by one row for the prior of each unknown."""

    def __init__(self, model: Model) -> None:
        self.model, self.scaling = model, model.scaling
        self.guess = self.scaling.scale(model.guess)
        priors = [one.prior or (one.guess, PRIOR_WIDTH * (one.high - one.low)) for one in model.unknowns]
        has_prior = np.array([one.prior is not None for one in model.unknowns], dtype=bool)
        means, widths = np.array(priors, dtype=np.float64).reshape(-1, 2).T
        span = self.scaling.high - self.scaling.low
        self.prior = np.where(has_prior, (means - self.scaling.low) / span, self.guess)
        self.widths = np.where(has_prior, widths / span, PRIOR_WIDTH)
        self.scales = [output.scale for output in model.outputs]
        self.triangle = np.diag(1.0 / self.widths)  # R of the last Jacobian's QR decomposition, priors included
        # Principal axes of the last Jacobian, a row each, and its singular values.
        self.axes, self.strengths = np.eye(len(self.prior)), np.full(len(self.prior), np.inf)

    def compute_data(self, scaled: Array) -> Array:
        """Return residuals without the prior's, (candidates, fitted samples); `DIVERGED_RESIDUAL` if not finite."""
        used, lengths = self.model.used, [len(output.measured) for output in self.model.outputs]
        simulated = self.model.simulate(self.scaling.unscale(scaled))[:, used]
        error = (simulated - self.model.measured[used]) / np.repeat(self.scales, lengths)[used]
        return np.asarray(np.where(np.isfinite(error), error, DIVERGED_RESIDUAL), dtype=np.float64)

    def __call__(self, scaled: Array) -> Array:
        """Return all residuals of one candidate, (fitted samples + unknowns,): those of the data, then of the prior."""
        return np.concatenate([self.compute_data(scaled[None])[0], self.compute_prior(scaled)])

    def compute_prior(self, scaled: Array) -> Array:
        """Return the rows of the prior, (..., unknowns): deviations in standard deviations."""
        return np.asarray((scaled - self.prior) / self.widths)

    def compute_costs(self, scaled: Array) -> Array:
        """Return half the sum of squared residuals of each candidate, the prior's included, (candidates,)."""
        data, prior = self.compute_data(scaled), self.compute_prior(scaled)
        return np.asarray(0.5 * (np.sum(data**2, axis=1) + np.sum(prior**2, axis=1)))

    def compute_data_jacobian(self, scaled: Array) -> Array:
        """Return the Jacobian of the data, (fitted samples, unknowns); update `triangle`, `axes` and `strengths`.

        A joint that sticks and slips makes residuals rough. Differences are therefore taken along the principal axes of
        the last Jacobian, and the wider the less an axis changes: directions that the log hardly identifies then show,
        and are not covered by roughness. They end at the bounds, where they are one-sided.
        """
        widths = np.clip(TARGET_RESIDUAL_CHANGE / self.strengths, MIN_DIFFERENCE_STEP, MAX_DIFFERENCE_STEP)
        up, down = (_step_within_bounds(scaled, sign * self.axes, widths) for sign in (1.0, -1.0))
        blocked = np.abs(up - down).max(axis=1) < 0.1 * MIN_DIFFERENCE_STEP
        up[blocked], down[blocked] = (
            np.clip(scaled + sign * MIN_DIFFERENCE_STEP * self.axes[blocked], 0.0, 1.0) for sign in (1.0, -1.0)
        )
        residuals = self.compute_data(np.vstack([up, down]))
        inverse_steps = np.linalg.pinv(up - down, len(up) * EPSILON)
        jacobian = np.asarray((inverse_steps @ (residuals[: len(up)] - residuals[len(up) :])).T)
        self.triangle = np.asarray(np.linalg.qr(np.vstack([jacobian, np.diag(1.0 / self.widths)]), mode="r"))
        _, self.strengths, self.axes = np.linalg.svd(self.triangle)
        return jacobian

    def compute_jacobian(self, scaled: Array) -> Array:
        """Return the Jacobian of all residuals, (rows, unknowns); update as `compute_data_jacobian` does."""
        return np.vstack([self.compute_data_jacobian(scaled), np.diag(1.0 / self.widths)])


def _step_within_bounds(scaled: Array, directions: Array, lengths: Array) -> Array:
    """Return the points at these lengths along each direction (a row), or as far as the bounds allow."""
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(
            directions > 0.0, (1.0 - scaled) / directions, np.where(directions < 0.0, -scaled / directions, np.inf)
        )
    return np.asarray(np.clip(scaled + np.minimum(lengths, room.min(axis=1))[:, None] * directions, 0.0, 1.0))


BOOTSTRAP_DRAWS = 1000
MAX_BLOCKS, MIN_BLOCKS = 100, 20  # blocks in all logs together
BLOCK_LENGTH_RATIO = 5.0  # length of a block over the residuals' correlation time
NORMAL_QUANTILE = 1.959964  # 95 % of a normal distribution lie within so many standard deviations


def covariance(jacobian: Array, residuals: Array, widths: Array) -> Array:
    """Return the covariance of the scaled unknowns for white residuals, of their estimated variance but at least 1.

    Args:
        jacobian: Jacobian of the residuals by the scaled unknowns, (samples, unknowns).
        residuals: over their scale, (samples,).
        widths: standard deviations of the scaled priors, (unknowns,).
    """
    variance = max(1.0, float(residuals @ residuals) / max(len(residuals) - jacobian.shape[1], 1))
    return _posterior_covariance(jacobian.T @ jacobian / variance, widths)


def bootstrap_moves(jacobian: Array, residuals: Array, widths: Array, blocks: NDArray[np.int64], seed: int) -> Array:
    """Return `BOOTSTRAP_DRAWS` moves of the optimum, (draws, unknowns), for blocks of samples drawn with replacement.

    Args:
        jacobian: Jacobian of the residuals by the scaled unknowns, (samples, unknowns).
        residuals: over their scale, (samples,).
        widths: standard deviations of the scaled priors, (unknowns,).
        blocks: number of each sample's block, (samples,).
        seed: seed of the draws.
    """
    count, n = int(blocks.max()) + 1, jacobian.shape[1]
    order = np.argsort(blocks, kind="stable")
    edges = np.searchsorted(blocks[order], np.arange(count + 1))
    H, g = np.empty((count, n, n)), np.empty((count, n))
    for k in range(count):
        rows = order[edges[k] : edges[k + 1]]
        H[k], g[k] = jacobian[rows].T @ jacobian[rows], jacobian[rows].T @ residuals[rows]
    # At the optimum the prior's gradient balances that of all blocks together: it is divided among them.
    g -= g.mean(axis=0)
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), size=BOOTSTRAP_DRAWS)
    moves = np.empty((BOOTSTRAP_DRAWS, n))
    for i, times in enumerate(drawn):
        moves[i] = -_posterior_covariance(np.tensordot(times, H, 1), widths) @ (times @ g)
    return moves


def assign_blocks(model: Model, residuals: Array) -> NDArray[np.int64]:
    """Return the number of the block of time of every fitted sample; outputs of a log share their blocks.

    Blocks last `BLOCK_LENGTH_RATIO` times the longest correlation time of an output; all logs together have
    `MIN_BLOCKS` to `MAX_BLOCKS`.
    """
    used, every = model.used, np.zeros(len(model.used))
    every[used] = residuals
    outputs = list(zip(model.slices, model.outputs, strict=True))
    parts = [(every[rows][used[rows]], output.time) for rows, output in outputs]
    correlation = max(_correlation_time(part, float(np.median(np.diff(time)))) for part, time in parts if len(part) > 1)
    logs = list(dict.fromkeys(output.log for output in model.outputs))
    spans = {log: max(float(o.time[-1] - o.time[0]) for o in model.outputs if o.log == log) for log in logs}
    total = sum(spans.values())
    length = min(max(BLOCK_LENGTH_RATIO * correlation, total / MAX_BLOCKS), total / MIN_BLOCKS)
    numbers, first = np.empty(len(used), dtype=np.int64), 0
    for log in logs:
        for rows, output in outputs:
            if output.log == log:
                numbers[rows] = first + ((output.time - output.time[0]) / length).astype(np.int64)
        first += int(spans[log] / length) + 1
    return np.unique(numbers[used], return_inverse=True)[1]


def confidence_interval(scaled: Array, variances: Array, moves: Array) -> tuple[Array, Array]:
    """Return the lower and upper ends of 95 %: the wider of covariance and bootstrap, no narrower than a difference.

    A simulation that sticks and slips is rough over steps smaller than those of the Jacobian, which says nothing there.

    Args:
        scaled: the optimum, (unknowns,).
        variances: covariance of the unknowns, (unknowns, unknowns).
        moves: moves of the optimum by the bootstrap, (draws, unknowns).
    """
    half = np.maximum(NORMAL_QUANTILE * np.sqrt(np.diag(variances)), MIN_DIFFERENCE_STEP)
    low, high = np.percentile(moves, [2.5, 97.5], axis=0)
    return scaled - np.maximum(half, -low), scaled + np.maximum(half, high)


def are_distinguishable(residuals: Array, others: Array, blocks: NDArray[np.int64]) -> bool:
    """Return whether the sums of squares of two sets of residuals differ by more than chance (95 %) between blocks.

    Args:
        residuals: residuals of one candidate, (samples,).
        others: residuals of another one, (samples,).
        blocks: number of each sample's block, (samples,).
    """
    differences = np.bincount(blocks, others**2 - residuals**2)
    deviation = np.sqrt(len(differences)) * float(differences.std(ddof=1))
    return bool(abs(differences.sum()) > NORMAL_QUANTILE * deviation)


def _correlation_time(residuals: Array, period: float) -> float:
    """Return the time until the autocorrelation of residuals falls below 1/e, s; all if it never does, 0 if equal."""
    r = residuals - residuals.mean()
    n = len(r)
    if not np.any(r):
        return 0.0
    power = np.abs(np.fft.rfft(r, 2 * n)) ** 2
    correlation = np.fft.irfft(power)[:n]
    below = np.flatnonzero(correlation < correlation[0] / np.e)
    return float(below[0] if len(below) else n) * period


def _posterior_covariance(H: Array, widths: Array) -> Array:
    """Return the inverse of the data's information H, clipped to be positive, plus the prior's."""
    # In units of the prior its own part is 1 in all directions.
    values, vectors = np.linalg.eigh(H * np.outer(widths, widths))
    relative = (vectors / (np.maximum(values, 0.0) + 1.0)) @ vectors.T
    return np.asarray(relative * np.outer(widths, widths), dtype=np.float64)
