"""All experiments of the paper on one bench, and all its claims."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
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

TOGETHER: dict[str, ModuleType] = {
    "axis one": axis_one,
    "statics and cam": statics,
    "two-axis arm": two_axis,
    "long-term integral": drift,
    "dither and averaging": dither,
    "open-loop characteristics": open_loop,
}
"""Experiments that may run at the same time, the longest first."""

EXPERIMENTS = len(TOGETHER) + 1


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
    """Perform every experiment, two at a time, and judge the paper's claims by what they found."""
    found: dict[ModuleType, Any] = {}

    def perform(item: tuple[str, ModuleType]) -> None:
        name, experiment = item
        found[experiment] = experiment.perform(bench)
        progress(name)

    # Compiled code runs without the interpreter's lock.
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(perform, TOGETHER.items()))
    perform(("control cycle", timing))
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
