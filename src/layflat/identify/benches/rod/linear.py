"""A model whose unknowns enter nearly linearly: its Jacobian, and the values that the logs ask for at once.

| symbol | meaning |
|---|---|
| J | how the scaled residuals change, per standard deviation of the prior of each unknown |
| r | scaled residuals where every unknown is as its prior expects it |
"""

import numpy as np

from layflat.arrays import Array
from layflat.identify.model import Model
from layflat.identify.unknown import Unknown

SAMPLES = 20_000  # of all logs together that are looked at
WIDTH = 1e-5
"""Of a difference, a share of the way between the bounds: the first sample is met linearly for small moves only."""


def expected(unknown: Unknown) -> tuple[float, float]:
    """Mean and standard deviation before any log: of its prior, or the guess and the way between the bounds."""
    return unknown.prior or (unknown.guess, unknown.high - unknown.low)


def linearised(model: Model, at: Array) -> tuple[Array, Array, list[int]]:
    """J, r and which unknowns the columns of J are: those that are not searched by their logarithm, and no shares."""
    linear = [i for i, one in enumerate(model.unknowns) if not one.log and ".split." not in one.path]
    linear = [i for i in linear if not model.unknowns[i].path.endswith("film_share")] + _of(model, "piston.area")
    used = np.flatnonzero(model.used)
    used = used[:: max(1, len(used) // SAMPLES)]
    moved = np.repeat(at[None], 2 * len(linear) + 1, axis=0)
    steps = np.empty(len(linear))
    for k, i in enumerate(linear):
        one = model.unknowns[i]
        up, down = (min(max(at[i] + way * WIDTH * (one.high - one.low), one.low), one.high) for way in (1.0, -1.0))
        moved[2 * k + 1, i], moved[2 * k + 2, i] = up, down
        steps[k] = (up - down) / expected(one)[1]
    scales = np.concatenate([np.full(len(one.measured), one.scale) for one in model.outputs])[used]
    scales *= np.sqrt(len(used) / max(int(model.used.sum()), 1))
    found = model.simulate(moved)[:, used] / scales
    J = ((found[1::2] - found[2::2]) / steps[:, None]).T
    away = np.array([(at[i] - mean) / spread for i in linear for mean, spread in [expected(model.unknowns[i])]])
    r = found[0] - model.measured[used] / scales - J @ away
    return J, r, linear


def linear_step(model: Model, at: Array) -> tuple[Array, float]:
    """Values with all that is linear as the logs, and the priors, ask for; and the sum of squares that is left."""
    J, r, linear = linearised(model, at)
    A, wanted = np.vstack([J, np.eye(len(linear))]), np.concatenate([-r, np.zeros(len(linear))])
    moves = np.linalg.lstsq(A, wanted)[0]
    found = at.copy()
    for i, move in zip(linear, moves, strict=True):
        one = model.unknowns[i]
        mean, spread = expected(one)
        found[i] = np.clip(mean + move * spread, one.low, one.high)
    return found, float(np.sum((A @ moves - wanted) ** 2))


def log_evidence(J: Array, r: Array) -> float:
    """Log of how likely the residuals are with unknowns drawn from their priors, but for a constant.

    Residuals are normal with the covariance I + J J' (mackay1992).
    """
    H = J.T @ J + np.eye(J.shape[1])
    g = J.T @ r
    return float(-0.5 * (r @ r - g @ np.linalg.solve(H, g)) - 0.5 * np.linalg.slogdet(H)[1])


def _of(model: Model, path: str) -> list[int]:
    return [i for i, one in enumerate(model.unknowns) if one.path == path]
