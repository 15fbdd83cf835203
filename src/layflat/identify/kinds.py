"""Several laws for the same logs: each is fitted, and the simplest that predicts as well as any is taken."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from layflat.identify.benches.contract import BenchDescription
from layflat.identify.fit import Fit
from layflat.identify.fit.result import choose
from layflat.identify.model import Model
from layflat.machine import Machine


@dataclass(frozen=True)
class Candidate:
    """A law that logs may obey: its name, the description that says it, and the model of that."""

    name: str
    described: Machine | BenchDescription
    model: Model
    replaces: Mapping[str, Any] = field(default_factory=dict)
    """Whole parts that stand in the description that was found, by path; none where it is the one begun with."""


def compared(candidates: Sequence[Candidate], fitted: Callable[[int, Candidate], Fit]) -> Fit:
    """Fit every candidate, the simplest first, and return the fit that is taken; its remarks say why.

    Candidates are compared by what they predict of what is not fitted. A search that the user stops ends it.
    """
    found: list[Fit] = []
    for number, candidate in enumerate(candidates):
        found.append(fitted(number, candidate))
        if found[-1].partial:
            return found[-1]
    if len(found) == 1:
        return found[0]
    errors = [_missed(one) for one in found]
    taken = choose(errors)
    found[taken].model.remarks = (*found[taken].model.remarks, _said([one.name for one in candidates], errors, taken))
    return found[taken]


def _missed(found: Fit) -> float:
    """Rms error of what was not fitted, over its range; of what was, where nothing was kept for validation."""
    shares = [one.share for one in found.predictions or found.qualities()]
    return float(np.sqrt(np.mean(np.square(shares)))) if np.isfinite(shares).all() else np.inf


def _said(names: Sequence[str], errors: Sequence[float], taken: int) -> str:
    """Which candidate is taken, and by how much the others differ."""
    each = ", ".join(f"{name} {100.0 * error:.2g} %" for name, error in zip(names, errors, strict=True))
    best = int(np.argmin(errors))
    if best == taken:
        why = f"{names[taken]} predicts best"
    else:
        why = f"{names[best]} predicts no better than the simpler {names[taken]}: the logs can't tell them apart"
    return f"Kinds compared by what they miss of the validation's range: {each}. {why[0].upper()}{why[1:]}."
