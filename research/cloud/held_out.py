"""Does the cloud predict what it was not told? `python -m research.cloud.held_out --out FILE`.

One finding at a time is left out: members walk on as far as the others let them, and of some of the machines to which
they come the claims of the one left out are evaluated. Prints a table in Markdown.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from layflat.experiments.bench import bench
from layflat.experiments.report import number
from layflat.experiments.spread import Spread, names_in, over, spreads
from layflat.files import write_text
from layflat.machine.cloud import PAPER
from research.calibration.evidence import Evidence
from research.calibration.findings import Findings
from research.cloud.__main__ import EFFORTS, walked
from research.cloud.made import write
from research.cloud.pinned import shares_of


@dataclass(frozen=True)
class Finding:
    """A finding that is left out."""

    says: str
    claim: str  # by its id
    quantities: tuple[str, ...]  # of the claim, by how their names begin
    shortfalls: tuple[str, ...]


SOON, LATE = "unbraked joint arrives too soon", "unbraked joint arrives too late"
ARM = ("arm settles too late", "arm does not come to rest")
KEPT = "earlier actuator opposes small motions too much"
HEIGHTS = "hysteresis is not the paper's"
FAST = "a fast dither moves the spool as well"
DRIFT = "long-term integral does not learn a drift"
RIPPLE = "dither does not show in the pressure"
FINDINGS = (
    Finding("the unbraked joint comes to rest late", "unbraked-joint", ("new joint arrives in",), (SOON, LATE)),
    Finding("it swings on a little", "unbraked-joint", ("oscillation left",), ("unbraked joint swings on",)),
    Finding("it is stable", "unbraked-joint", ("overshoot",), ("unbraked joint overshoots",)),
    Finding("the earlier one settles soon", "unbraked-joint", ("earlier",), ("earlier actuator settles too late",)),
    Finding("the braked joint settles soon", "braked-joint", ("settling",), ("braked joint settles too late",)),
    Finding("it carries twice as much", "braked-joint", ("ratio",), ("limits are not as one to two",)),
    Finding("a small motion is opposed less", "loop-character", ("height kept by the earlier",), (KEPT,)),
    Finding("dither shows in the pressure", "dither-motion", ("pressure ripple kept",), (RIPPLE,)),
    Finding("hysteresis is 25, 7 and 25 %", "open-loop-hysteresis", ("",), (HEIGHTS,)),
    Finding("a fast dither moves the spool less", "dither-need", ("gain",), (FAST,)),
    Finding("the long-term integral learns", "long-term-integral", ("drift taken over",), (DRIFT,)),
    Finding("the arm settles", "two-axis-settling", ("",), ARM),
    Finding("it comes back to one place", "repeatability", ("",), ("arm does not come back",)),
    Finding("the large joint is pushed little", "coupling", ("large", "small"), ("large joint is pushed",)),
)


def predicted(finding: Finding, *, seed: int, rounds: int, count: int) -> list[Spread]:
    """Return what the cloud made from the other findings says of one."""
    findings = Findings(Evidence(bench()), frozenset(finding.shortfalls))
    *_, (walk, _) = walked(findings, shares_of(), seed=seed, rounds=rounds, spread=0.0, efforts=EFFORTS[1:2])
    some = walk.shares[np.random.default_rng(seed).permutation(len(walk.shares))[:count]]
    with TemporaryDirectory() as folder:
        file = Path(folder) / "held-out.cloud.json"
        write(file, list(some), "")
        claims = list(over(names_in(file, count)))
    own = [[one for one in every if one.id == finding.claim] for every in claims]
    return [one for one in spreads(own) if one.quantity.startswith(finding.quantities)]


def told(says: str, found: Sequence[Spread]) -> list[str]:
    """Rows in Markdown."""
    return [
        f"| {'' if i else says} | {one.quantity} | {number(one.low)} to {number(one.high)} "
        f"{one.unit.removeprefix('1')} | {one.agreeing:.0%} |"
        for i, one in enumerate(found)
    ]


def main() -> None:
    """Leave out each, tell, write."""
    asked = argparse.ArgumentParser(prog="python -m research.cloud.held_out", description=__doc__)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--rounds", type=int, default=40, help="of the walk without each finding")
    asked.add_argument("--count", type=int, default=40, help="machines of which the claims are evaluated")
    asked.add_argument("--out", type=Path, default=Path("build/held-out.json"))
    given = asked.parse_args()
    rows = ["| finding left out | quantity | predicted, 5 to 95 % | claim agrees with |", "|---|---|---|---|"]
    everything = {}
    for finding in FINDINGS:
        found = predicted(finding, seed=given.seed, rounds=given.rounds, count=given.count)
        everything[finding.says] = [asdict(one) for one in found]
        rows += told(finding.says, found)
        sys.stderr.write("\n".join(told(finding.says, found)) + "\n")
    given.out.parent.mkdir(parents=True, exist_ok=True)
    write_text(given.out, json.dumps({"cloud": PAPER.name, "predicted": everything}, indent=1) + "\n")
    sys.stdout.write("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
