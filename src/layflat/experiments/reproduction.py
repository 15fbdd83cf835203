"""All experiments of the paper on one bench, and all its claims."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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

EXPERIMENTS = 7


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
    found_statics = statics.perform(bench)
    progress("statics and cam")
    found_loops = open_loop.perform(bench)
    progress("open-loop characteristics")
    found_axis = axis_one.perform(bench)
    progress("axis one")
    found_arm = two_axis.perform(bench)
    progress("two-axis arm")
    found_dither = dither.perform(bench)
    progress("dither and averaging")
    found_drift = drift.perform(bench)
    progress("long-term integral")
    found_timing = timing.perform(bench)
    progress("control cycle")
    judged = [
        *statics.claims(found_statics),
        *open_loop.claims(found_loops),
        *axis_one.claims(found_axis),
        *two_axis.claims(found_arm),
        *dither.claims(found_dither),
        *drift.claims(found_drift),
        *timing.claims(found_timing),
    ]
    return Reproduction(
        bench,
        found_statics,
        found_loops,
        found_axis,
        found_arm,
        found_dither,
        found_drift,
        found_timing,
        sorted(judged, key=lambda claim: ORDER.index(claim.id)),
    )
