"""Checks of a log before a fit: each module looks for one kind of fault."""

from layflat.arrays import Dataset
from layflat.identify.logs.checks import levels, presence, signs, stops, units
from layflat.identify.logs.checks.channels import Issue, merge_issues, prepare_log

ISSUE_CHECKS = (
    presence.missing_issues, presence.constant_issues, presence.clock_issues, units.unit_issues, units.gauge_issues,
    levels.level_issues, signs.sign_issues, signs.lag_issues, stops.stop_issues, presence.stationary_issues,
)  # fmt: skip


def find_issues(log: Dataset, description: object | None = None) -> list[Issue]:
    """Return the issues of a log, the worst first.

    Args:
        log: data set of `read_log`, or of a simulation run.
        description: the bench; of a `Machine` strokes, supply, valve, sensors and control cycle are used.
    """
    checked = prepare_log(log, description)
    return merge_issues(issue for issues in ISSUE_CHECKS for issue in issues(checked))
