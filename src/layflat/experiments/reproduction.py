"""All experiments of the paper on one bench, and all its claims."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from layflat.experiments import axis_one, dither, drift, open_loop, statics, timing, two_axis
from layflat.experiments.bench import Bench
from layflat.experiments.claim import Claim

Progress = Callable[[str], None]
"""Called with the name of each experiment when it is done."""

ORDER = (
    "table-1",
    "mean-torque",
    "large-joint-torque",
    "small-joint-torque",
    "torque-per-mass",
    "constant-torque",
    "open-loop-hysteresis",
    "loop-character",
    "rig-variants",
    "unbraked-joint",
    "braked-joint",
    "two-axis-settling",
    "repeatability",
    "coupling",
    "overall-hysteresis",
    "dither-motion",
    "dither-need",
    "averaging",
    "long-term-integral",
    "control-cycle",
)
"""The claims in the order of the paper."""

EXPERIMENTS: dict[str, ModuleType] = {
    "statics and cam": statics,
    "open-loop characteristics": open_loop,
    "axis one": axis_one,
    "two-axis arm": two_axis,
    "dither and averaging": dither,
    "long-term integral": drift,
    "control cycle": timing,
}
"""Each module performs its experiment and judges the claims that rest on it."""


@dataclass(frozen=True)
class Reproduction:
    """What all experiments found, and the claims judged by it."""

    bench: Bench
    statics: statics.Statics
    open_loop: open_loop.OpenLoop
    axis_one: axis_one.AxisOne
    two_axis: two_axis.TwoAxis
    dither: dither.Dither
    drift: drift.Drift
    timing: timing.Timing
    claims: list[Claim]

    @property
    def agrees(self) -> bool:
        """Whether every claim agrees."""
        return all(claim.agrees for claim in self.claims)


def reproduce(bench: Bench, progress: Progress = lambda _: None) -> Reproduction:
    """Perform every experiment and judge the paper's claims by what they found."""
    found: dict[ModuleType, Any] = {}
    for name, experiment in EXPERIMENTS.items():
        found[experiment] = experiment.perform(bench)
        progress(name)
    judged = [claim for experiment, result in found.items() for claim in experiment.claims(result)]
    return Reproduction(
        bench,
        found[statics],
        found[open_loop],
        found[axis_one],
        found[two_axis],
        found[dither],
        found[drift],
        found[timing],
        sorted(judged, key=lambda claim: ORDER.index(claim.id)),
    )
