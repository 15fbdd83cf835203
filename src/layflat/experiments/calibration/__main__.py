"""Find what the paper leaves open: `python -m layflat.experiments.calibration --seed 1 --minutes 25 [--write]`.

First axis one and the earlier actuator, which share a controller; then the large joint, in the arm. The same seed
finds the same if the time suffices. With --write the values go into the built-in descriptions, as calibrated.
"""

import argparse
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from layflat.arrays import Array
from layflat.description.change import changed_all
from layflat.experiments.axis_one import AxisOne
from layflat.experiments.bench import Bench, bench
from layflat.experiments.calibration.effort import Effort
from layflat.experiments.calibration.evidence import Evidence
from layflat.experiments.calibration.findings import Findings
from layflat.experiments.calibration.search import Best, Sought, search
from layflat.experiments.calibration.unknowns import (
    AIR,
    DAMPING,
    LOSSES,
    Unknown,
    as_text,
    by_path,
    gains,
    known_to,
    to_shares,
    to_values,
    values_of,
    with_losses,
)
from layflat.experiments.calibration.written import loss_shares, put_into, put_loss_shares
from layflat.experiments.controller import Controller
from layflat.experiments.dither import Dither
from layflat.experiments.open_loop import OpenLoop
from layflat.experiments.reproduction import disagreeing, reproduce
from layflat.experiments.two_axis import TwoAxis

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


def calibrated(kind: str, seed: int, minutes: float, *, anew: bool) -> tuple[Bench, list[dict[str, Any]], list[Best]]:
    """Search stage by stage; returns the machines, and of each stage texts by path and what it found."""
    on, texts, found, until = bench(), list[dict[str, Any]](), list[Best](), time.monotonic() + 60.0 * minutes
    if on.arm.joint["small"].losses.kind != kind:
        on, anew = replace(on, arm=with_losses(on.arm, kind), earlier=with_losses(on.earlier, kind)), True
    for stage, share in zip(stages(kind), SHARES, strict=True):
        now = values_of(on.arm if stage.arm else on.axis_one, stage.unknowns)
        first, seconds = None if anew else to_shares(stage.unknowns, now), share * (until - time.monotonic())
        for best, level, left in search(stage.sought(on), first, len(stage.unknowns), seed=seed, seconds=seconds):
            found[len(texts) :] = [best]
            at = f"{stage.name}, {left / 60:.1f} min left: all lack {level:.2f} or less"
            asked = f" (claimed: not {best.denied})" if best.denied else ""
            sys.stderr.write(f"{at}; the best {best.cost:.2f}{asked}: {told(best.lacks)}\n")
        texts.append(stage.texts(found[-1].shares))
        on = stage.put_into(on, texts[-1])
    return on, texts, found


def told(found: Mapping[str, float]) -> str:
    """What is short, in a line."""
    short = {name: value for name, value in found.items() if value > 1e-3}
    return ", ".join(f"{name} ({value:.2f})" for name, value in short.items()) or "nothing"


def main() -> None:
    """Search, check by all claims, and write if asked to."""
    asked = argparse.ArgumentParser(prog="python -m layflat.experiments.calibration", description=__doc__)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--minutes", type=float, default=25.0, help="time for the whole search")
    asked.add_argument("--kind", choices=sorted(LOSSES), default="elasto-slip", help="of losses")
    asked.add_argument("--anew", action="store_true", help="begin anywhere, not at what stands in the descriptions")
    asked.add_argument("--write", action="store_true", help="put the values into the built-in descriptions")
    given = asked.parse_args()
    if given.write:
        put_loss_shares(loss_shares())
    on, texts, found = calibrated(given.kind, given.seed, given.minutes, anew=given.anew)
    lines = [
        f"{stage.name}: short of {told(best.lacks)}; {best.rounds} rounds"
        for stage, best in zip(stages(given.kind), found, strict=True)
    ]
    done = reproduce(on)
    wrong = [claim.id for claim in done.claims if claim.agrees is False]
    lines.append(done.summary + (f": not {', '.join(wrong)}" if wrong else ""))
    lines += [f"{path} = {text}" for own in texts for path, text in own.items()]
    sys.stdout.write("\n".join(lines) + "\n")
    if given.write:
        axis_one, arm = texts
        # The controller of section 4.1 is that of the earlier actuator; the arm was tuned by itself.
        put_into("paper-small-joint", {path: text for path, text in axis_one.items() if ".gains." in path})
        put_into("paper-arm", axis_one | arm)


if __name__ == "__main__":
    main()
