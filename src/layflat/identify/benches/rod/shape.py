"""Terms of a law that logs have to show before they are taken: a seal whose shape, or friction, bends with pressure."""

from collections.abc import Mapping, Sequence

import numpy as np

from layflat.arrays import Array
from layflat.identify.benches.rod.linear import linearised, log_evidence, prior_bounds
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
