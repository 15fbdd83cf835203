"""Stages of the calibration: first axis one and the earlier actuator, then the large joint in the arm."""

import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from layflat.arrays import Array
from layflat.description.change import changed_all
from layflat.experiments.axis_one import AxisOneExperiment
from layflat.experiments.bench import ReproductionBench, load_bench
from layflat.experiments.controller import ControllerExperiment
from layflat.experiments.dither import DitherExperiment
from layflat.experiments.open_loop import OpenLoopExperiment
from layflat.experiments.reproduction import first_disagreement
from layflat.experiments.two_axis import TwoAxisExperiment
from layflat.machine.exchanged import with_losses
from research.calibration.effort import EvaluationEffort
from research.calibration.evidence import Evidence
from research.calibration.findings import Findings
from research.calibration.search import MAX_RESIDUAL, BestMachine, SearchTarget, search
from research.calibration.unknowns import (
    AIR,
    DAMPING,
    LOSSES,
    STARTS,
    Unknown,
    as_text,
    by_path,
    gains,
    to_shares,
    to_values,
    values_in,
    values_of,
)

TIME_FRACTIONS = (0.85, 1.0)  # of the time that is left, for each stage


@dataclass(frozen=True)
class CalibrationStage:
    """Stage of the calibration: its unknowns, and the findings that it has to meet."""

    name: str
    unknowns: tuple[Unknown, ...]
    arm: bool  # True: findings of the arm; False: those of axis one

    def values(self, shares: Array) -> dict[str, Array]:
        """Numbers (SI) by path of machines (machines, unknowns)."""
        return by_path(self.unknowns, to_values(self.unknowns, shares))

    def sought(self, on: ReproductionBench) -> SearchTarget:
        """Return the target of the search on a bench."""
        findings = Findings(Evidence(on))

        def parts(shares: Array, seed: int, effort: EvaluationEffort) -> dict[str, Array]:
            return findings.parts(shares, self.values, arm=self.arm, seed=seed, effort=effort)

        def lack(shares: Array, seed: int, effort: EvaluationEffort, level: Array) -> Array:
            return findings.lack(shares, self.values, arm=self.arm, seed=seed, effort=effort, level=level)

        return SearchTarget(parts, lack, lambda shares: self.denied(self.put_into(on, self.texts(shares))))

    def denied(self, on: ReproductionBench) -> str:
        """Return the id of the first claim of this stage that disagrees; empty if all agree."""
        return first_disagreement(
            on,
            (TwoAxisExperiment, DitherExperiment)
            if self.arm
            else (OpenLoopExperiment, AxisOneExperiment, ControllerExperiment),
        )

    def texts(self, shares: Array) -> dict[str, Any]:
        """Return the values of a machine (unknowns,) as in a description, by path."""
        return as_text(self.unknowns, to_values(self.unknowns, shares))

    def put_into(self, on: ReproductionBench, texts: Mapping[str, Any]) -> ReproductionBench:
        """Return the bench with changed values; those of the arm's stage do not change the earlier actuator."""
        changed = replace(on, arm=changed_all(on.arm, texts))
        return changed if self.arm else replace(changed, earlier=changed_all(on.earlier, values_in(on.earlier, texts)))


def stages(kind: str) -> tuple[CalibrationStage, CalibrationStage]:
    """Return both stages of the calibration, with losses of a kind."""
    large = tuple(one for one in AIR if one.name.startswith("large "))
    shared = tuple(one for one in AIR if one not in large)
    return (
        CalibrationStage("axis one", (*gains("small"), *shared, *LOSSES[kind], DAMPING), arm=False),
        CalibrationStage("the arm", (*large, *gains("large"), *gains("small")), arm=True),
    )


def calibrate_machines(
    kind: str, seed: int, minutes: float, *, anew: bool, doubt: float = MAX_RESIDUAL
) -> tuple[ReproductionBench, list[dict[str, Any]], list[BestMachine]]:
    """Search stage by stage; return the machines, and for each stage its values by path and its best machine.

    Args:
        kind: of losses.
        seed: of the search.
        minutes: for all of it.
        anew: whether to begin at random points, and not near the built-in machines.
        doubt: mean shortfall with other noise up to which a machine is accepted.
    """
    on, texts, found, until = (
        load_bench(),
        list[dict[str, Any]](),
        list[BestMachine](),
        time.monotonic() + 60.0 * minutes,
    )
    if on.arm.joint["small"].losses.kind != kind:
        arm, earlier = (with_losses(machine, kind, STARTS[kind]) for machine in (on.arm, on.earlier))
        on, anew = replace(on, arm=arm, earlier=earlier), True
    for stage, share in zip(stages(kind), TIME_FRACTIONS, strict=True):
        now = values_of(on.arm if stage.arm else on.axis_one, stage.unknowns)
        first, seconds = None if anew else to_shares(stage.unknowns, now), share * (until - time.monotonic())
        searching = search(stage.sought(on), first, len(stage.unknowns), seed=seed, seconds=seconds, doubt=doubt)
        for best, level, left in searching:
            found[len(texts) :] = [best]
            at = f"{stage.name}, {left / 60:.1f} min left: all lack {level:.2f} or less"
            asked = f" (claimed: {best.denied or f'all, in doubt {best.doubt:.2f}'})" if best.denied is not None else ""
            sys.stderr.write(f"{at}; the best {best.cost:.2f}{asked}: {describe_shortfalls(best.lacks)}\n")
        texts.append(stage.texts(found[-1].shares))
        on = stage.put_into(on, texts[-1])
    return on, texts, found


def describe_shortfalls(found: Mapping[str, float]) -> str:
    """Return one line of text with the shortfalls."""
    short = {name: value for name, value in found.items() if value > 1e-3}
    return ", ".join(f"{name} ({value:.2f})" for name, value in short.items()) or "nothing"
