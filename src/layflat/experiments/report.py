"""Results of a reproduction on disk: claims.json and one self-contained report.html."""

from __future__ import annotations

import json
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

import layflat
from layflat.experiments.claim import Claim
from layflat.experiments.figures import figures
from layflat.experiments.questions import Answer
from layflat.experiments.reproduction import Reproduction
from layflat.files import write_text
from layflat.machine.listing import Line
from layflat.plot.page import page

TINY, LARGE = 1e-4, 1e5  # numbers below and above these are not written out


def number(value: float) -> str:
    """Return a number as people read it; a time that is not finite is one that never comes."""
    if not isfinite(value):
        return "never"
    if abs(value) >= LARGE:
        return f"{value:,.0f}"
    return f"< {TINY:g}" if 0.0 < value < TINY else f"{value:.5g}"


AGREES = {True: "yes", False: "NO", None: "-"}
COLUMNS = ("claim", "quantity", "the paper", "simulated", "unit", "agrees")


def table(claims: Sequence[Claim]) -> list[list[str]]:
    """Return rows with `COLUMNS`: one for each quantity, or for the reason why a claim was not evaluated."""
    rows = []
    for one in claims:
        told = [[q.name, q.paper, number(q.value), q.unit.removeprefix("1")] for q in one.quantities]
        for i, cells in enumerate(told or [[one.reason, "", "", ""]]):
            rows.append(["" if i else one.id, *cells, "" if i else AGREES[one.agrees]])
    return rows


def write_claims(found: Reproduction, path: Path) -> Path:
    """Write the claims as a JSON list.

    Raises:
        OutputError: it can't be written there.
    """
    records = [claim.record() for claim in found.claims]
    return write_text(path, json.dumps(records, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def write_report(found: Reproduction, assumed: list[Line], path: Path, answers: Sequence[Answer] = ()) -> Path:
    """Write the report as one HTML file that needs nothing else.

    Args:
        found: the experiments.
        assumed: lines of the description that the paper does not give.
        path: of the file.
        answers: to the open questions, as far as there are any.

    Raises:
        OutputError: it can't be written there.
    """
    html = page(
        "layflat.experiments",
        "report.html.j2",
        machine=found.bench.arm.title,
        version=layflat.__version__,
        summary=found.summary,
        claims=found.claims,
        number=number,
        figures=list(figures(found)),
        assumed=assumed,
        answers=list(answers),
    )
    return write_text(path, html)
