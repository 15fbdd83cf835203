"""Checks of a log before it is fitted: each module asks one kind of question."""

from layflat.arrays import Dataset
from layflat.identify.logs.checks import alive, gauges, lags, levels, missing, signs, stops, units
from layflat.identify.logs.checks.channels import Issue, checked_log, ordered

QUESTIONS = (
    missing.issues, alive.issues, missing.clocks, units.issues, gauges.issues, levels.issues, signs.issues,
    lags.issues, stops.issues, alive.still,
)  # fmt: skip


def check(log: Dataset, description: object | None = None) -> list[Issue]:
    """Look for what is wrong with a log, the worst first.

    Args:
        log: as `read_log` gives it, or a run.
        description: what is known of the bench; of a layflat `Machine` strokes, supply, valve and sensors are used.
    """
    checked = checked_log(log, description)
    return ordered(issue for issues in QUESTIONS for issue in issues(checked))
