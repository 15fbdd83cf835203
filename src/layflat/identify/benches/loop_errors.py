"""How well loops are predicted, beside how high they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from layflat.identify.benches.loops import LoopModel
from layflat.identify.benches.rod import RodModel
from layflat.identify.model import Array
from layflat.sim.loop_height import loop_height


@dataclass(frozen=True)
class LoopError:
    """Error of a predicted loop, over its height.

    Args:
        log: which log.
        judged: whether none of it was fitted.
        height: of the measured loop (see `loop_height`), N or N m.
        raw: rms of the error, as a share of the height.
        friction: the same with the log's mean error taken away: what friction alone is missed by.
    """

    log: str
    judged: bool
    height: float
    raw: float
    friction: float


def loop_errors(model: LoopModel | RodModel, simulated: Array) -> list[LoopError]:
    """Errors of all logs of a fitted model.

    Args:
        model: what was fitted.
        simulated: all outputs with the values found, one after the other, as in `Fit.simulated`.
    """
    found = []
    for place, output, motion in zip(model.slices, model.outputs, model.motions, strict=True):
        height = loop_height(motion, output.measured)
        error = (simulated[place] - output.measured)[np.isfinite(output.measured)]
        rms, spread = float(np.sqrt(np.mean(error**2))), float(np.std(error))
        judged = not bool(output.fitted.any())
        found.append(LoopError(output.log, judged, height, rms / height, spread / height))
    return found
