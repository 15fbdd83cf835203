"""All experiments of the paper on one bench, and all its claims."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

from layflat.experiments.axis_one import AxisOne
from layflat.experiments.bench import Bench
from layflat.experiments.claim import CLAIMS, Claim, Experiment, Rule
from layflat.experiments.controller import Controller
from layflat.experiments.dither import Dither
from layflat.experiments.open_loop import OpenLoop
from layflat.experiments.statics import Statics
from layflat.experiments.two_axis import TwoAxis
from layflat.plot.page import Drawn

ORDER = tuple(CLAIMS)  # the claims in the order of the paper

STOPPED = "stopped before it was evaluated"


@dataclass
class Reproduction:
    """The experiments on one bench, their claims in the order of the paper, and figures that are drawn already."""

    statics: Statics
    open_loop: OpenLoop
    axis_one: AxisOne
    two_axis: TwoAxis
    dither: Dither
    controller: Controller
    claims: list[Claim] = field(default_factory=list)
    drawn: dict[str, Drawn] = field(default_factory=dict)

    @classmethod
    def on(cls, bench: Bench) -> Self:
        """Return one of which nothing has been performed yet."""
        return cls(Statics(bench), OpenLoop(bench), AxisOne(bench), TwoAxis(bench), Dither(bench), Controller(bench))

    def rules(self, *, aside: bool) -> list[tuple[Rule, Experiment]]:
        """Return the rules of the claims, each with its experiment; `aside`: of those that another process may perform.

        Either take about as long, where kernels have to be compiled and where they are there.
        """
        here = self.statics, self.two_axis, self.dither, self.controller
        there = self.axis_one, self.open_loop
        return [(rule, one) for one in (there if aside else here) for rule in one.rules()]

    @property
    def bench(self) -> Bench:
        """Return what was tested."""
        return self.statics.bench

    @property
    def evaluated(self) -> list[Claim]:
        """The claims that could be evaluated."""
        return [claim for claim in self.claims if claim.agrees is not None]

    @property
    def stopped(self) -> bool:
        """True if it was interrupted before all claims were evaluated."""
        return any(claim.reason == STOPPED for claim in self.claims)

    @property
    def agrees(self) -> bool:
        """True if every claim that could be evaluated agrees."""
        return all(claim.agrees for claim in self.evaluated)

    @property
    def summary(self) -> str:
        """Return how many claims agree, in a line."""
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


def reproduce(
    bench: Bench,
    progress: Callable[[int, int], None] = lambda *_: None,
    others: Iterable[Claim | Drawn] = (),
    draw: Callable[[Reproduction], Iterable[Drawn]] = lambda _: (),
) -> Reproduction:
    """Perform every experiment and evaluate the paper's claims; an interruption (Ctrl-C) leaves the rest open.

    `progress` is called with the number of claims that are evaluated, and with how many there are. `others`: claims and
    figures that another process comes to (see report.py); what it does not give is evaluated here, last. `draw`: draws
    the figures of what was evaluated so far, while that process works.
    """
    found, claims = Reproduction.on(bench), dict[str, Claim]()

    def take(claim: Claim) -> None:
        claims[claim.id] = claim
        progress(len(claims), len(ORDER))

    try:
        for rule, experiment in found.rules(aside=False):
            take(rule.evaluated(experiment))
        found.claims = list(claims.values())
        found.drawn = {one.id: one for one in draw(found)}
        for one in others:
            if isinstance(one, Claim):
                take(one)
            else:
                found.drawn[one.id] = one
        for rule, experiment in found.rules(aside=True):
            if rule.claim.id not in claims:
                take(rule.evaluated(experiment))
    except KeyboardInterrupt:
        pass
    found.claims = [claims.get(key) or replace(claim, reason=STOPPED) for key, claim in CLAIMS.items()]
    return found
