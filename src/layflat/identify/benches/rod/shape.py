"""Whether logs show that pressure changes the shape of a seal: the simpler law is taken unless they do."""

from typing import TYPE_CHECKING

import numpy as np

from layflat.identify.benches.rod.linear import linearised, log_evidence
from layflat.identify.benches.rod.unknowns import shape_unknowns
from layflat.identify.unknown import Unknown

if TYPE_CHECKING:
    from layflat.identify.benches.rod.model import RodModel

PRESSURES = 3  # of fitted logs, at least
APART = 0.1  # pressures are different if they are this share of their range apart
ODDS = 1.0
"""Log of the odds from which on the law with more unknowns is taken, some 3 to 1: "positive" evidence (kass1995)."""

FEW = "Logs at fewer than three pressures can't show whether pressure changes the shape of the seal: taken as not."


def shape_shown(model: "RodModel") -> tuple[tuple[Unknown, ...], str]:
    """Unknowns of a model, those of the shape only if its logs show them; and what the logs show, in a sentence."""
    shape = [one.path for one in shape_unknowns(model.origin, model.sizes)]
    rest = tuple(one for one in model.unknowns if one.path not in shape)
    pressures = np.sort(model.sizes.pressures)
    if 1 + int((np.diff(pressures) > APART * np.ptp(pressures)).sum()) < PRESSURES:
        return rest, FEW
    J, r, linear = linearised(model, model.starts()[0])
    plain = np.array([model.unknowns[i].path not in shape for i in linear])
    gain = log_evidence(J, r) - log_evidence(J[:, plain], r)
    odds = f"log of the odds {gain:+.1f}, where {ODDS:g} is asked for"
    if gain < ODDS:
        return rest, f"The logs do not show that pressure changes the shape of the seal ({odds}): taken as not."
    return model.unknowns, f"The logs show that pressure changes the shape of the seal ({odds})."
