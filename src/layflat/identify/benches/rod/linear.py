"""A model whose unknowns enter nearly linearly: its Jacobian, the values that logs ask for at once, and their evidence.

Terms of a law have to be shown by the logs before they are taken: a seal whose shape, or friction, bends with pressure.

| symbol | meaning |
|---|---|
| J | how the scaled residuals change, per standard deviation of the prior of each unknown |
| r | scaled residuals where every unknown is as its prior expects it |
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from layflat.arrays import Array
from layflat.identify.model import Model
from layflat.identify.unknown import Unknown

PRESSURES = 3  # of fitted logs, at least
APART = 0.1  # pressures are different if they are this share of their range apart
ODDS = 1.0
"""Log of the odds from which on the law with more unknowns is taken, some 3 to 1: "positive" evidence (kass1995)."""

SHAPE = ("piston.area_growth", "piston.area_slope_growth")
EXPONENT = ("friction.exponent",)
TERMS: Mapping[str, Sequence[str]] = {
    "that pressure changes the shape of the seal": SHAPE,
    "that friction grows otherwise than in proportion to pressure": EXPONENT,
}
"""Unknowns by what they stand for, in words."""

NOT_SHOWN = "The logs do not show {} (log of the odds {:+.1f}, where {:g} is asked for): taken as not."
FEW = "Logs at fewer than three pressures can't show {}: taken as not."


def terms_shown(model: Model, pressures: Array) -> tuple[tuple[Unknown, ...], tuple[str, ...]]:
    """Return the unknowns of a model, of `TERMS` only those that its logs show, and what they show, in sentences.

    The term that is likeliest is tried first, and another one beside it.

    Args:
        model: of a rod.
        pressures: at which its fitted logs were taken, Pa.
    """
    present = {one.path for one in model.unknowns}
    left = {words: set(paths) for words, paths in TERMS.items() if present & set(paths)}
    every = set().union(*left.values())
    if not left:
        return model.unknowns, ()
    pressures = np.sort(pressures)
    if 1 + int((np.diff(pressures) > APART * np.ptp(pressures)).sum()) < PRESSURES:
        return _without(model, every), tuple(FEW.format(words) for words in left)
    J, r, linear = linearised(model, model.starts()[0], EXPONENT)
    paths = [model.unknowns[i].path for i in linear]
    lower, upper = prior_bounds(model, linear)

    def evidence(missing: set[str]) -> float:
        there = [path not in missing for path in paths]
        return log_evidence(J[:, there], r, (lower[there], upper[there]))

    missing, said = every, list[str]()
    while left:
        gains = {words: evidence(missing - own) - evidence(missing) for words, own in left.items()}
        best = max(gains, key=lambda words: gains[words])
        if gains[best] < ODDS:
            said += [NOT_SHOWN.format(words, gain, ODDS) for words, gain in gains.items()]
            break
        missing = missing - left.pop(best)
        said.append(f"The logs show {best} (log of the odds {gains[best]:+.1f}).")
    return _without(model, missing), tuple(said)


def _without(model: Model, missing: set[str]) -> tuple[Unknown, ...]:
    return tuple(one for one in model.unknowns if one.path not in missing)


CURVED = ("film_share", "exponent")  # ends of paths of what is searched linearly, but does not enter so

SAMPLES = 20_000  # of all logs together that are looked at
WIDTH = 1e-5
"""Of a difference, a share of the way between the bounds: the first sample is met linearly for small moves only."""


def expected(unknown: Unknown) -> tuple[float, float]:
    """Mean and standard deviation before any log: of its prior, or the guess and the way between the bounds."""
    return unknown.prior or (unknown.guess, unknown.high - unknown.low)


def linearised(model: Model, at: Array, bent: Collection[str] = ()) -> tuple[Array, Array, list[int]]:
    """Return J, r and which unknowns the columns of J are.

    Args:
        model: the model.
        at: values of its unknowns.
        bent: paths of unknowns that are linear nearby only, and wanted nevertheless.
    """
    linear = [i for i, one in enumerate(model.unknowns) if not one.log and ".split." not in one.path]
    linear = [i for i in linear if not model.unknowns[i].path.endswith(CURVED) or model.unknowns[i].path in bent]
    linear += _of(model, "piston.area")
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


def log_evidence(J: Array, r: Array, bounds: tuple[Array, Array]) -> float:
    """Log of how likely the residuals are with unknowns drawn from their priors within their bounds.

    But for a constant. Residuals are normal with the covariance I + J J' (mackay1992); an unknown that the logs hold at
    its bound, as a friction that would be negative, is no unknown any more.

    Args:
        J: residuals by unknowns in standard deviations of their priors, (residuals, unknowns).
        r: residuals where every unknown is as its prior expects it, (residuals,).
        bounds: lower and upper ones of the unknowns, in the same standard deviations about the expected values.
    """
    from scipy.optimize import lsq_linear  # noqa: PLC0415  # scipy.optimize takes long to import

    n = J.shape[1]
    if n == 0:
        return float(-0.5 * r @ r)
    # An orthogonal transformation changes no sum of squares, and leaves as many rows as there are columns.
    Q, R = np.linalg.qr(np.vstack([J, np.eye(n)]))
    wanted = Q.T @ np.concatenate([-r, np.zeros(n)])
    found = lsq_linear(R, wanted, bounds=bounds, method="bvls")
    left = float(r @ r - wanted @ wanted + np.sum((R @ found.x - wanted) ** 2))
    free = found.active_mask == 0
    H = (R.T @ R)[np.ix_(free, free)]
    return float(-0.5 * left - 0.5 * np.linalg.slogdet(H)[1])


def prior_bounds(model: Model, linear: list[int]) -> tuple[Array, Array]:
    """Return the bounds of unknowns, in standard deviations of their priors about what these expect."""
    ends = []
    for i in linear:
        one = model.unknowns[i]
        mean, spread = expected(one)
        ends.append(((one.low - mean) / spread, (one.high - mean) / spread))
    lower, upper = np.array(ends).reshape(-1, 2).T
    return lower, upper


def _of(model: Model, path: str) -> list[int]:
    return [i for i, one in enumerate(model.unknowns) if one.path == path]
