"""Nearly linear part of a model: its Jacobian, the least-squares step, and the evidence of optional terms.

Optional terms of a law are fitted only if the logs show them: a seal whose shape, or friction, changes with pressure.

| symbol | meaning |
|---|---|
| J | derivatives of the scaled residuals by the linear unknowns, in standard deviations of their priors |
| r | scaled residuals, simulated less measured, where every linear unknown has the mean of its prior |
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from layflat.arrays import Array
from layflat.identify.model import Model, Unknown

MIN_PRESSURES = 3  # different ones among the fitted logs, for optional terms
MIN_PRESSURE_GAP = 0.1  # between different pressures, as a fraction of their range
MIN_LOG_ODDS = 1.0
"""Log of the odds above which the law with more unknowns is taken, some 3 to 1: "positive" evidence (kass1995)."""

SHAPE_PATHS = ("piston.area_growth", "piston.area_slope_growth")
EXPONENT_PATHS = ("friction.exponent",)
OPTIONAL_TERMS: Mapping[str, Sequence[str]] = {
    "that pressure changes the shape of the seal": SHAPE_PATHS,
    "that friction grows otherwise than in proportion to pressure": EXPONENT_PATHS,
}
"""Paths of the unknowns of each term, by its words in remarks."""

NOT_SHOWN_REMARK = "The logs do not show {} (log of the odds {:+.1f}, at least {:g} needed): it is left out."
TOO_FEW_REMARK = "Logs at fewer than three pressures can't show {}: it is left out."


def select_terms(model: Model, pressures: Array) -> tuple[tuple[Unknown, ...], tuple[str, ...]]:
    """Return the unknowns of a model without the terms that its logs don't show, and remarks on these.

    The most probable term is tried first, and another one in addition.

    Args:
        model: model of a rod.
        pressures: pressures at which its fitted logs were taken, Pa.

    Returns:
        Unknowns, with those of `OPTIONAL_TERMS` that the logs show, and a sentence for each term.
    """
    present = {unknown.path for unknown in model.unknowns}
    candidates = {words: set(paths) for words, paths in OPTIONAL_TERMS.items() if present & set(paths)}
    optional = set().union(*candidates.values())
    if not candidates:
        return model.unknowns, ()
    pressures = np.sort(pressures)
    if 1 + int((np.diff(pressures) > MIN_PRESSURE_GAP * np.ptp(pressures)).sum()) < MIN_PRESSURES:
        return _drop_unknowns(model, optional), tuple(TOO_FEW_REMARK.format(words) for words in candidates)
    J, r, linear = linearise(model, model.starts()[0], EXPONENT_PATHS)
    paths = [model.unknowns[i].path for i in linear]
    lower, upper = prior_bounds(model, linear)

    def evidence(missing: set[str]) -> float:
        included = [path not in missing for path in paths]
        return log_evidence(J[:, included], r, (lower[included], upper[included]))

    missing, remarks = optional, list[str]()
    while candidates:
        gains = {words: evidence(missing - term) - evidence(missing) for words, term in candidates.items()}
        best = max(gains, key=lambda words: gains[words])
        if gains[best] < MIN_LOG_ODDS:
            remarks += [NOT_SHOWN_REMARK.format(words, gain, MIN_LOG_ODDS) for words, gain in gains.items()]
            break
        missing = missing - candidates.pop(best)
        remarks.append(f"The logs show {best} (log of the odds {gains[best]:+.1f}).")
    return _drop_unknowns(model, missing), tuple(remarks)


def _drop_unknowns(model: Model, missing: set[str]) -> tuple[Unknown, ...]:
    return tuple(one for one in model.unknowns if one.path not in missing)


NONLINEAR_SUFFIXES = ("film_fraction", "exponent")  # of unknowns that are searched linearly, but don't enter linearly

MAX_SAMPLES = 20_000  # of all logs together, above twice which every second or further one is used
DIFFERENCE_WIDTH = 1e-5
"""Half the width of a difference, over the range between the bounds: the model is linear for small steps only."""


def prior_moments(unknown: Unknown) -> tuple[float, float]:
    """Return mean and standard deviation of an unknown's prior; without one, its guess and upper less lower bound."""
    return unknown.prior or (unknown.guess, unknown.high - unknown.low)


def linearise(model: Model, values: Array, nearby: Collection[str] = ()) -> tuple[Array, Array, list[int]]:
    """Return J and r near values of the unknowns, and the positions of J's columns among the unknowns.

    Args:
        model: model of a rod.
        values: values of its unknowns (SI), (unknowns,), about which differences are taken.
        nearby: paths of unknowns that are linear nearby only, and included nevertheless.

    Returns:
        J (samples, linear unknowns) and r (samples,), extrapolated from the values to the means of the priors; then the
        positions. They are of fewer than twice `MAX_SAMPLES` samples, weighted as if they were all.
    """
    linear = [i for i, one in enumerate(model.unknowns) if not one.log and ".split." not in one.path]
    linear = [
        i for i in linear
        if not model.unknowns[i].path.endswith(NONLINEAR_SUFFIXES) or model.unknowns[i].path in nearby
    ]  # fmt: skip
    linear += _positions_of(model, "piston.area")
    used = np.flatnonzero(model.used)
    used = used[:: max(1, len(used) // MAX_SAMPLES)]
    moved = np.repeat(values[None], 2 * len(linear) + 1, axis=0)
    steps = np.empty(len(linear))
    for k, i in enumerate(linear):
        low, high = model.unknowns[i].low, model.unknowns[i].high
        up, down = (min(max(values[i] + sign * DIFFERENCE_WIDTH * (high - low), low), high) for sign in (1.0, -1.0))
        moved[2 * k + 1, i], moved[2 * k + 2, i] = up, down
        steps[k] = (up - down) / prior_moments(model.unknowns[i])[1]
    scales = np.concatenate([np.full(len(one.measured), one.scale) for one in model.outputs])[used]
    scales *= np.sqrt(len(used) / max(int(model.used.sum()), 1))
    simulated = model.simulate(moved)[:, used] / scales
    J = ((simulated[1::2] - simulated[2::2]) / steps[:, None]).T
    priors = [prior_moments(model.unknowns[i]) for i in linear]
    offsets = np.array([(values[i] - mean) / deviation for i, (mean, deviation) in zip(linear, priors, strict=True)])
    r = simulated[0] - model.measured[used] / scales - J @ offsets
    return J, r, linear


def linear_step(model: Model, values: Array) -> tuple[Array, float]:
    """Return values with the linear unknowns solved by least squares and clipped to their bounds, and a sum of squares.

    The sum is that of the scaled residuals and of the deviations from the priors at the solution, before it is clipped.
    """
    J, r, linear = linearise(model, values)
    A, b = np.vstack([J, np.eye(len(linear))]), np.concatenate([-r, np.zeros(len(linear))])
    moves = np.linalg.lstsq(A, b)[0]
    solution = values.copy()
    for i, move in zip(linear, moves, strict=True):
        unknown = model.unknowns[i]
        mean, deviation = prior_moments(unknown)
        solution[i] = np.clip(mean + move * deviation, unknown.low, unknown.high)
    return solution, float(np.sum((A @ moves - b) ** 2))


def log_evidence(J: Array, r: Array, bounds: tuple[Array, Array]) -> float:
    """Return the log of the marginal likelihood of the residuals, but for a constant.

    Unknowns are drawn from their priors within their bounds; residuals are normal with the covariance I + J J'
    (mackay1992). An unknown that the logs hold at its bound, as a friction that would be negative, counts as known.

    Args:
        J: derivatives of the residuals by the unknowns, in standard deviations of their priors, (residuals, unknowns).
        r: residuals where every unknown has the mean of its prior, (residuals,).
        bounds: lower and upper ones of the unknowns, in the same standard deviations about the means.
    """
    from scipy.optimize import lsq_linear  # noqa: PLC0415  # scipy.optimize takes long to import

    n = J.shape[1]
    if n == 0:
        return float(-0.5 * r @ r)
    # An orthogonal transformation changes no sum of squares, and leaves as many rows as there are columns.
    Q, R = np.linalg.qr(np.vstack([J, np.eye(n)]))
    projected = Q.T @ np.concatenate([-r, np.zeros(n)])
    result = lsq_linear(R, projected, bounds=bounds, method="bvls")
    remainder = float(r @ r - projected @ projected + np.sum((R @ result.x - projected) ** 2))
    free = result.active_mask == 0
    H = (R.T @ R)[np.ix_(free, free)]
    return float(-0.5 * remainder - 0.5 * np.linalg.slogdet(H)[1])


def prior_bounds(model: Model, linear: list[int]) -> tuple[Array, Array]:
    """Return lower and upper bounds of the unknowns at positions, in deviations of their priors about the means."""
    ends = []
    for i in linear:
        unknown = model.unknowns[i]
        mean, deviation = prior_moments(unknown)
        ends.append(((unknown.low - mean) / deviation, (unknown.high - mean) / deviation))
    lower, upper = np.array(ends).reshape(-1, 2).T
    return lower, upper


def _positions_of(model: Model, path: str) -> list[int]:
    return [i for i, one in enumerate(model.unknowns) if one.path == path]
