"""Uncertainty of fitted values: from the Jacobian, and from a bootstrap over blocks of time.

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
from layflat.identify.fit.residuals import STEP
from layflat.identify.model import Model

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
