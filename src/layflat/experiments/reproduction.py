"""Reproduction of the paper: all its experiments on one bench, and all its claims."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from layflat.description.wrong import did_you_mean
from layflat.errors import InputError
from layflat.experiments.axis_one import AxisOneExperiment
from layflat.experiments.bench import ReproductionBench, load_bench
from layflat.experiments.claim import PAPER_CLAIMS, Claim, ClaimRule, Experiment
from layflat.experiments.controller import ControllerExperiment
from layflat.experiments.dither import DitherExperiment
from layflat.experiments.open_loop import OpenLoopExperiment
from layflat.experiments.statics import StaticsExperiment
from layflat.experiments.two_axis import TwoAxisExperiment
from layflat.machine import Machine
from layflat.plot import CaptionedFigure
from layflat.plot.tables import html_table

CLAIM_IDS = tuple(PAPER_CLAIMS)  # in the order of the paper

STOPPED_REASON = "stopped before it was evaluated"


@dataclass
class Reproduction:
    """The experiments on one bench, their evaluated claims in the order of the paper, and figures drawn so far."""

    statics: StaticsExperiment
    open_loop: OpenLoopExperiment
    axis_one: AxisOneExperiment
    two_axis: TwoAxisExperiment
    dither: DitherExperiment
    controller: ControllerExperiment
    claims: list[Claim] = field(default_factory=list)
    drawn: dict[str, CaptionedFigure] = field(default_factory=dict)

    @classmethod
    def from_bench(cls, bench: ReproductionBench) -> Self:
        """Return a reproduction of which nothing has been evaluated yet."""
        return cls(
            StaticsExperiment(bench),
            OpenLoopExperiment(bench),
            AxisOneExperiment(bench),
            TwoAxisExperiment(bench),
            DitherExperiment(bench),
            ControllerExperiment(bench),
        )

    def rules(self, *, in_subprocess: bool) -> list[tuple[ClaimRule, Experiment]]:
        """Return the rules of the claims with their experiments: those for a subprocess, or those for this process.

        Both take about as long, with and without compilation of the kernels.
        """
        here = self.statics, self.two_axis, self.dither, self.controller
        in_other_process = self.axis_one, self.open_loop
        experiments = in_other_process if in_subprocess else here
        return [(rule, experiment) for experiment in experiments for rule in experiment.rules()]

    @property
    def bench(self) -> ReproductionBench:
        """Return the machines that are tested."""
        return self.statics.bench

    @property
    def evaluated(self) -> list[Claim]:
        """Return the claims that could be evaluated."""
        return [claim for claim in self.claims if claim.agrees is not None]

    @property
    def was_interrupted(self) -> bool:
        """True if the reproduction was interrupted before all claims were evaluated."""
        return any(claim.reason == STOPPED_REASON for claim in self.claims)

    @property
    def agrees(self) -> bool:
        """True if every claim that could be evaluated agrees."""
        return all(claim.agrees for claim in self.evaluated)

    @property
    def summary(self) -> str:
        """Return one line of text: the numbers of claims that agree, do not apply or were not reached."""
        text = f"{sum(claim.agrees is True for claim in self.claims)} of {len(self.evaluated)} claims agree"
        unreached = sum(claim.reason == STOPPED_REASON for claim in self.claims)
        lacking = len(self.claims) - len(self.evaluated) - unreached
        text += f"; {lacking} do not apply to this machine" if lacking else ""
        return text + (f"; partial: stopped before {unreached} were evaluated" if unreached else "")

    def _repr_html_(self) -> str:
        rows = [(claim.id, claim.says, claim.verdict, claim.criterion) for claim in self.claims]
        return html_table(f"{self.bench.arm.name}: {self.summary}", ("claim", "the paper", "verdict", "when"), rows)


EXPERIMENT_TYPES: tuple[Callable[[ReproductionBench], Experiment], ...] = (
    TwoAxisExperiment,
    OpenLoopExperiment,
    AxisOneExperiment,
    DitherExperiment,
    ControllerExperiment,
    StaticsExperiment,
)
"""Experiments by how often they disagree and how little they cost: most often and cheapest first."""


def first_disagreement(
    bench: ReproductionBench, experiments: Sequence[Callable[[ReproductionBench], Experiment]] = EXPERIMENT_TYPES
) -> str:
    """Return the id of the first claim that disagrees; empty if none does.

    Later claims are not evaluated.
    """
    claims = (
        rule.evaluate_claim(one) for one in (experiment(bench) for experiment in experiments) for rule in one.rules()
    )
    return next((claim.id for claim in claims if claim.agrees is False), "")


def reproduce(
    machine: str | Path | Machine | ReproductionBench = "paper-arm",
    *,
    claims: Collection[str] = CLAIM_IDS,
    progress: Callable[[int, int], None] = lambda *_: None,
    others: Iterable[Claim | CaptionedFigure] = (),
    draw: Callable[[Reproduction], Iterable[CaptionedFigure]] = lambda _: (),
) -> Reproduction:
    """Evaluate the paper's claims by all experiments; an interruption (Ctrl-C) leaves the rest without a verdict.

    Args:
        machine: the arm under test: a built-in name, a file or a machine; or the bench of all machines.
        claims: short names of the claims to evaluate; default: all.
        progress: called with the number of evaluated claims and the number of all.
        others: claims and figures from another process (`report.evaluate_other_claims`); claims that are not chosen
            are ignored, and those that it does not yield are evaluated here, last.
        draw: draws the figures of the claims evaluated so far, while that process works.

    Raises:
        InputError: the machine is wrong, or there is no claim of a name.

    Example:
        >>> import layflat as lf
        >>> lf.reproduce("paper-arm", claims=["table-1", "mean-torque"]).summary
        '2 of 2 claims agree'
    """
    chosen = {key: PAPER_CLAIMS[key] for key in CLAIM_IDS if key in _check_claims(claims)}
    bench = machine if isinstance(machine, ReproductionBench) else load_bench(machine)
    reproduction, evaluated = Reproduction.from_bench(bench), dict[str, Claim]()

    def add_claim(claim: Claim) -> None:
        """Keep an evaluated claim, and report progress."""
        evaluated[claim.id] = claim
        progress(len(evaluated), len(chosen))

    try:
        for rule, experiment in reproduction.rules(in_subprocess=False):
            if rule.claim.id in chosen:
                add_claim(rule.evaluate_claim(experiment))
        reproduction.claims = list(evaluated.values())
        reproduction.drawn = {result.id: result for result in draw(reproduction)}
        for result in others:
            if isinstance(result, Claim):
                if result.id in chosen:
                    add_claim(result)
            else:
                reproduction.drawn[result.id] = result
        for rule, experiment in reproduction.rules(in_subprocess=True):
            if rule.claim.id in chosen and rule.claim.id not in evaluated:
                add_claim(rule.evaluate_claim(experiment))
    except KeyboardInterrupt:
        pass
    reproduction.claims = [evaluated.get(key) or replace(claim, reason=STOPPED_REASON) for key, claim in chosen.items()]
    return reproduction


def _check_claims(claims: Collection[str]) -> Collection[str]:
    """Return short names of claims; raise InputError for an unknown one."""
    unknown = next((key for key in claims if key not in PAPER_CLAIMS), None)
    if unknown is not None:
        raise InputError(
            f"unknown claim {unknown!r}", where="claims", right=did_you_mean(unknown, CLAIM_IDS, "give {}")
        )
    return claims
