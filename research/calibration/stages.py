"""The search in its parts: first axis one and the earlier actuator, then the large joint in the arm."""

import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from layflat.arrays import Array
from layflat.description.change import changed_all
from layflat.experiments.axis_one import AxisOne
from layflat.experiments.bench import Bench, bench
from layflat.experiments.controller import Controller
from layflat.experiments.dither import Dither
from layflat.experiments.open_loop import OpenLoop
from layflat.experiments.reproduction import disagreeing
from layflat.experiments.two_axis import TwoAxis
from layflat.machine.exchanged import with_losses
from research.calibration.effort import Effort
from research.calibration.evidence import Evidence
from research.calibration.findings import Findings
from research.calibration.search import SURELY, Best, Sought, search
from research.calibration.unknowns import (
    AIR,
    DAMPING,
    LOSSES,
    STARTS,
    Unknown,
    as_text,
    by_path,
    gains,
    known_to,
    to_shares,
    to_values,
    values_of,
)

SHARES = (0.85, 1.0)  # of the time that is left, for each stage


@dataclass(frozen=True)
class Stage:
    """A part of the search: what is sought, and what of the evidence it is to meet."""

    name: str
    unknowns: tuple[Unknown, ...]
    arm: bool  # whether it is the arm's findings, or axis one's

    def values(self, shares: Array) -> dict[str, Array]:
        """Numbers (SI) by path of machines (machines, unknowns)."""
        return by_path(self.unknowns, to_values(self.unknowns, shares))

    def sought(self, on: Bench) -> Sought:
        """What machines are sought by that take the place of those of a bench."""
        findings = Findings(Evidence(on))

        def parts(shares: Array, seed: int, effort: Effort) -> dict[str, Array]:
            return findings.parts(shares, self.values, arm=self.arm, seed=seed, effort=effort)

        def lack(shares: Array, seed: int, effort: Effort, level: Array) -> Array:
            return findings.lack(shares, self.values, arm=self.arm, seed=seed, effort=effort, level=level)

        return Sought(parts, lack, lambda shares: self.denied(self.put_into(on, self.texts(shares))))

    def denied(self, on: Bench) -> str:
        """Return which of the claims that this stage decides disagrees first; empty if all agree."""
        return disagreeing(on, (TwoAxis, Dither) if self.arm else (OpenLoop, AxisOne, Controller))

    def texts(self, shares: Array) -> dict[str, Any]:
        """Return what a description says of a machine (unknowns,), by path."""
        return as_text(self.unknowns, to_values(self.unknowns, shares))

    def put_into(self, on: Bench, texts: Mapping[str, Any]) -> Bench:
        """Return the machines with what a description may say in place; the earlier actuator keeps out of the arm's."""
        changed = replace(on, arm=changed_all(on.arm, texts))
        return changed if self.arm else replace(changed, earlier=changed_all(on.earlier, known_to(on.earlier, texts)))


def stages(kind: str) -> tuple[Stage, Stage]:
    """Both parts of the search, with losses of a kind."""
    large = tuple(one for one in AIR if one.name.startswith("large "))
    shared = tuple(one for one in AIR if one not in large)
    return (
        Stage("axis one", (*gains("small"), *shared, *LOSSES[kind], DAMPING), arm=False),
        Stage("the arm", (*large, *gains("large"), *gains("small")), arm=True),
    )


def calibrated(
    kind: str, seed: int, minutes: float, *, anew: bool, doubt: float = SURELY
) -> tuple[Bench, list[dict[str, Any]], list[Best]]:
    """Search stage by stage; returns the machines, and of each stage texts by path and what it found.

    Args:
        kind: of losses.
        seed: of the search.
        minutes: for all of it.
        anew: whether to begin anywhere, and not near the built-in machines.
        doubt: what machines may lack with other noise for a stage to end before its time.
    """
    on, texts, found, until = bench(), list[dict[str, Any]](), list[Best](), time.monotonic() + 60.0 * minutes
    if on.arm.joint["small"].losses.kind != kind:
        arm, earlier = (with_losses(machine, kind, STARTS[kind]) for machine in (on.arm, on.earlier))
        on, anew = replace(on, arm=arm, earlier=earlier), True
    for stage, share in zip(stages(kind), SHARES, strict=True):
        now = values_of(on.arm if stage.arm else on.axis_one, stage.unknowns)
        first, seconds = None if anew else to_shares(stage.unknowns, now), share * (until - time.monotonic())
        searching = search(stage.sought(on), first, len(stage.unknowns), seed=seed, seconds=seconds, doubt=doubt)
        for best, level, left in searching:
            found[len(texts) :] = [best]
            at = f"{stage.name}, {left / 60:.1f} min left: all lack {level:.2f} or less"
            asked = f" (claimed: {best.denied or f'all, in doubt {best.doubt:.2f}'})" if best.denied is not None else ""
            sys.stderr.write(f"{at}; the best {best.cost:.2f}{asked}: {told(best.lacks)}\n")
        texts.append(stage.texts(found[-1].shares))
        on = stage.put_into(on, texts[-1])
    return on, texts, found


def told(found: Mapping[str, float]) -> str:
    """What is short, in a line."""
    short = {name: value for name, value in found.items() if value > 1e-3}
    return ", ".join(f"{name} ({value:.2f})" for name, value in short.items()) or "nothing"
