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
from layflat.files import whole_file
from layflat.machine.listing import Line
from layflat.plot.page import page


def number(value: float) -> str:
    """A number as people read it."""
    if not isfinite(value):
        return "none"
    return f"{value:.5g}"


def lines(claim: Claim) -> list[str]:
    """What was simulated, a line each."""
    if isinstance(claim.simulated, dict):
        return [f"{name}: {number(value)}" for name, value in claim.simulated.items()]
    return [f"{claim.simulated:.7g}"]


def write_claims(found: Reproduction, path: Path) -> Path:
    """Write the claims as a JSON list.

    Raises:
        OutputError: it can't be written there.
    """
    records = [claim.record() for claim in found.claims]
    with whole_file(path) as temporary:
        temporary.write_text(
            json.dumps(records, indent=2, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8"
        )
    return path


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
        agreed=sum(claim.agrees for claim in found.claims),
        claims=[{**vars(claim), "lines": lines(claim)} for claim in found.claims],
        figures=list(figures(found)),
        assumed=assumed,
        answers=list(answers),
    )
    with whole_file(path) as temporary:
        temporary.write_text(html, encoding="utf-8")
    return path
