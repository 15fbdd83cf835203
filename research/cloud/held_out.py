"""Cross-validation of the cloud on left-out findings: `python -m research.cloud.held_out --out FILE`.

One finding at a time is left out: members move on within the limits of the others, and the claims of the left-out
finding are evaluated with some of the machines. Prints a table in Markdown.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from layflat.experiments.bench import load_bench
from layflat.experiments.report import format_number
from layflat.experiments.spread import QuantityRange, cloud_file_members, evaluate_machines, quantity_ranges
from layflat.files import write_text
from layflat.machine.cloud import PAPER_CLOUD
from research.calibration.evidence import Evidence
from research.calibration.findings import Findings
from research.cloud.__main__ import WALK_STAGES, walk_from
from research.cloud.made import write
from research.cloud.pinned import shares_of


@dataclass(frozen=True)
class Finding:
    """Finding that is left out."""

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


def predict_finding(finding: Finding, *, seed: int, rounds: int, count: int) -> list[QuantityRange]:
    """Return the ranges of a finding's numbers over a cloud sampled from the other findings."""
    findings = Findings(Evidence(load_bench()), frozenset(finding.shortfalls))
    *_, (walk, _) = walk_from(findings, shares_of(), seed=seed, rounds=rounds, spread=0.0, efforts=WALK_STAGES[1:2])
    some = walk.shares[np.random.default_rng(seed).permutation(len(walk.shares))[:count]]
    with TemporaryDirectory() as folder:
        file = Path(folder) / "held-out.cloud.json"
        write(file, list(some), "")
        claims = list(evaluate_machines(cloud_file_members(file, count)))
    own = [[one for one in every if one.id == finding.claim] for every in claims]
    return [one for one in quantity_ranges(own) if one.quantity.startswith(finding.quantities)]


def markdown_rows(says: str, found: Sequence[QuantityRange]) -> list[str]:
    """Return table rows in Markdown."""
    return [
        f"| {'' if i else says} | {one.quantity} | {format_number(one.low)} to {format_number(one.high)} "
        f"{one.unit.removeprefix('1')} | {one.agreeing:.0%} |"
        for i, one in enumerate(found)
    ]


def main() -> None:
    """Leave out each finding in turn, report, and write the results."""
    asked = argparse.ArgumentParser(prog="python -m research.cloud.held_out", description=__doc__)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--rounds", type=int, default=40, help="of the walk without each finding")
    asked.add_argument("--count", type=int, default=40, help="machines of which the claims are evaluated")
    asked.add_argument("--out", type=Path, default=Path("build/held-out.json"))
    given = asked.parse_args()
    rows = ["| finding left out | quantity | predicted, 5 to 95 % | claim agrees with |", "|---|---|---|---|"]
    everything = {}
    for finding in FINDINGS:
        found = predict_finding(finding, seed=given.seed, rounds=given.rounds, count=given.count)
        everything[finding.says] = [asdict(one) for one in found]
        rows += markdown_rows(finding.says, found)
        sys.stderr.write("\n".join(markdown_rows(finding.says, found)) + "\n")
    given.out.parent.mkdir(parents=True, exist_ok=True)
    write_text(given.out, json.dumps({"cloud": PAPER_CLOUD.name, "predicted": everything}, indent=1) + "\n")
    sys.stdout.write("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
