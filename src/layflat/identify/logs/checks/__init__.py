"""Checks of a log before it is fitted: each module asks one kind of question."""

from __future__ import annotations

from typing import TYPE_CHECKING

from layflat.identify.logs.checks import alive, gauges, missing, signs, units
from layflat.identify.logs.checks.channels import checked_log
from layflat.identify.logs.issue import Issue, ordered

if TYPE_CHECKING:
    import xarray


def check(log: xarray.Dataset, description: object | None = None) -> list[Issue]:
    """Look for what is wrong with a log, the worst first.

    Args:
        log: as `read_log` gives it, or a run.
        description: what is known of the bench; of a layflat `Machine` strokes, supply, valve and sensors are used.
    """
    checked = checked_log(log, description)
    questions = (
        missing.issues, alive.issues, missing.clocks, units.issues, gauges.issues, signs.issues, alive.still,
    )  # fmt: skip
    return ordered(issue for issues in questions for issue in issues(checked))
