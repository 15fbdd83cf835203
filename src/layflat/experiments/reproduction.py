"""All experiments of the paper on one bench, and all its claims."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from layflat.experiments.axis_one import AxisOne
from layflat.experiments.bench import Bench
from layflat.experiments.claim import CLAIMS, Claim, Experiment
from layflat.experiments.controller import Controller
from layflat.experiments.dither import Dither
from layflat.experiments.open_loop import OpenLoop
from layflat.experiments.statics import Statics
from layflat.experiments.two_axis import TwoAxis

ORDER = tuple(CLAIMS)  # the claims in the order of the paper

STOPPED = "stopped before it was evaluated"


@dataclass
class Reproduction:
    """The experiments on one bench, and the claims evaluated by them, in the order of the paper."""

    statics: Statics
    open_loop: OpenLoop
    axis_one: AxisOne
    two_axis: TwoAxis
    dither: Dither
    claims: list[Claim] = field(default_factory=list)

    @property
    def bench(self) -> Bench:
        """What was tested."""
        return self.statics.bench

    @property
    def evaluated(self) -> list[Claim]:
        """The claims that could be evaluated."""
        return [claim for claim in self.claims if claim.agrees is not None]

    @property
    def stopped(self) -> bool:
        """Whether it was interrupted before all claims were evaluated."""
        return any(claim.reason == STOPPED for claim in self.claims)

    @property
    def agrees(self) -> bool:
        """Whether every claim that could be evaluated agrees."""
        return all(claim.agrees for claim in self.evaluated)

    @property
    def summary(self) -> str:
        """How many claims agree, in a line."""
        said = f"{sum(claim.agrees is True for claim in self.claims)} of {len(self.evaluated)} claims agree"
        left = sum(claim.reason == STOPPED for claim in self.claims)
        lacking = len(self.claims) - len(self.evaluated) - left
        said += f"; {lacking} do not apply to this machine" if lacking else ""
        return said + (f"; partial: stopped before {left} were evaluated" if left else "")


EXPERIMENTS: tuple[Callable[[Bench], Experiment], ...] = (TwoAxis, OpenLoop, AxisOne, Dither, Controller, Statics)
"""Those that disagree most often first, dearer ones later."""


def disagreeing(bench: Bench, experiments: Sequence[Callable[[Bench], Experiment]] = EXPERIMENTS) -> str:
    """Return the first claim of some experiments that disagrees, by its id; empty if none does.

    What comes after it is not evaluated.
    """
    claims = (rule.evaluated(one) for one in (experiment(bench) for experiment in experiments) for rule in one.rules())
    return next((claim.id for claim in claims if claim.agrees is False), "")


def reproduce(bench: Bench, progress: Callable[[int, int], None] = lambda *_: None) -> Reproduction:
    """Perform every experiment and evaluate the paper's claims; an interruption (Ctrl-C) leaves the rest open.

    `progress` is called with the number of claims that are evaluated, and with how many there are.
    """
    found = Reproduction(Statics(bench), OpenLoop(bench), AxisOne(bench), TwoAxis(bench), Dither(bench))
    drawn = (found.statics, found.open_loop, found.axis_one, found.two_axis, found.dither)
    rules = [(rule, experiment) for experiment in (*drawn, Controller(bench)) for rule in experiment.rules()]
    try:
        for rule, experiment in rules:
            found.claims.append(rule.evaluated(experiment))
            progress(len(found.claims), len(rules))
    except KeyboardInterrupt:
        found.claims += [rule.open(STOPPED) for rule, _ in rules[len(found.claims) :]]
    return found
