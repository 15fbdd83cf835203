"""Checks of a log before it is fitted: each module asks for faults of one kind."""

from layflat.arrays import Dataset
from layflat.identify.logs.checks import levels, presence, signs, stops, units
from layflat.identify.logs.checks.channels import Issue, checked_log, ordered

QUESTIONS = (
    presence.missing_issues, presence.constant_issues, presence.clock_issues, units.unit_issues, units.gauge_issues,
    levels.issues, signs.sign_issues, signs.lag_issues, stops.issues, presence.stationary_issues,
)  # fmt: skip


def check(log: Dataset, description: object | None = None) -> list[Issue]:
    """Look for what is wrong with a log, the worst first.

    Args:
        log: as `read_log` gives it, or a run.
        description: what is known of the bench; of a layflat `Machine` strokes, supply, valve and sensors are used.
    """
    checked = checked_log(log, description)
    return ordered(issue for issues in QUESTIONS for issue in issues(checked))
