"""How well hysteresis curves are predicted, beside how high they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from layflat.identify.benches.hysteresis.height import loop_height
from layflat.identify.model import Array, Output


class CurveModel(Protocol):
    """A model of hysteresis curves: its outputs, where each stands among all samples, and the motion of each."""

    @property
    def outputs(self) -> tuple[Output, ...]: ...  # noqa: D102

    @property
    def slices(self) -> tuple[slice, ...]: ...  # noqa: D102

    @property
    def motions(self) -> tuple[Array, ...]: ...  # noqa: D102


@dataclass(frozen=True)
class LoopError:
    """Error of a predicted curve, over its height.

    Args:
        log: which log.
        validation: whether none of it was fitted.
        height: of the measured curve (see `loop_height`), N or N m.
        raw: rms of the error, as a share of the height.
        friction: the same with the log's mean error taken away: what friction alone is missed by.
    """

    log: str
    validation: bool
    height: float
    raw: float
    friction: float


def loop_errors(model: CurveModel, simulated: Array) -> list[LoopError]:
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
        found.append(LoopError(output.log, not output.fitted.any(), height, rms / height, spread / height))
    return found
