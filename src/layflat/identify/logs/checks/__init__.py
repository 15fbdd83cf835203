"""Is a log fit to be explained? Each module asks one kind of question of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from layflat.identify.logs.checks import alive, clocks, excited, gauges, missing, signs, units
from layflat.identify.logs.checks.bench import bench_of
from layflat.identify.logs.finding import LogFinding, ordered

if TYPE_CHECKING:
    import xarray


def check(log: xarray.Dataset, description: object | None = None) -> list[LogFinding]:
    """Look for what is wrong with a log, the worst first.

    Args:
        log: as `read_log` gives it, or a run.
        description: what is known of the bench; of a layflat `Machine` strokes, supply, valve and sensors are used.
    """
    bench = bench_of(log, description)
    findings = [
        finding
        for questions in (missing, alive, clocks, units, gauges, signs, excited)
        for finding in questions.findings(bench)
    ]
    return ordered(findings)
