"""What came of a run in words: a row a pick, what went wrong, why others were not picked, and a summary."""

from collections import Counter
from collections.abc import Iterable
from math import isfinite

from layflat.cell.file.model import Cell
from layflat.cell.plan.containers import Fruit
from layflat.cell.work.records import Delivery, Pick, Verdict
from layflat.cell.work.results import Summary, counted

COLUMNS = ("pick", "fruit", "mm", "place", "result", "error (mm)", "peak (m/s2)", "s", "air (Nl)")
"""Heads of what `row` returns."""


def row(name: str, pick: Pick, verdict: Verdict) -> tuple[str, ...]:
    """Return a pick as a row of a table, under a name such as "2.5": the fifth of the second delivery."""
    fruit, place = pick.choice.fruit, pick.choice.place
    what = name, sort(fruit), f"{1e3 * fruit.diameter:.0f}", f"{place.container} {place.name}", verdict.word(pick)
    true = known(1e3 * verdict.release_error, 1), known(verdict.peak_acceleration, 0)
    return (*what, *true, f"{pick.end - pick.begin:.2f}", f"{pick.air:.1f}")


def sort(fruit: Fruit) -> str:
    """Return kind and grade of a fruit."""
    return f"{fruit.kind}, {fruit.grade}" if fruit.grade else fruit.kind


def trouble(name: str, pick: Pick) -> str:
    """Return what went wrong in a pick; empty where nothing did."""
    if not pick.trouble:
        return ""
    return f"pick {name}, {pick.outcome.name.lower()}, {counted(pick.tries, 'try', 'tries')}: {pick.trouble}"


def not_picked(reasons: Iterable[str]) -> list[str]:
    """Return how many fruit were not picked for each reason, a line each."""
    return [f"{count} not picked: {reason}" for reason, count in Counter(reasons).items()]


def summary(cell: Cell, deliveries: Iterable[Delivery]) -> list[str]:
    """Return the figures of all picks, a line for each question; none where nothing was picked."""
    found, limits = Summary(deliveries), cell.limits
    if not found.picks:
        return []
    share = f"{found.correct / found.picks:.1%}"
    picks, collisions = counted(found.picks, "pick"), counted(found.collisions, "collision")
    lines = [
        f"{found.correct} of {picks} correct: in the chosen place, of its kind and grade ({share})",
        f"{found.picks_a_minute:.1f} picks a minute, {found.air:.1f} normal litres of air each",
    ]
    if isfinite(found.release_error_mm):
        worst = found.release_error_worst_mm
        lines.append(f"placement error: {found.release_error_mm:.1f} mm (95 %), {worst:.1f} mm at most")
    lines.append(f"{collisions}; {found.overlooked} overlooked that could have been packed")
    if isfinite(found.peak_acceleration):
        peak = f"{found.peak_acceleration:.0f} m/s2 at most (limit {limits.acceleration:.0f})"
        lines.append(f"fruit: {peak}, pressed by {found.press:.0f} N at most (limit {limits.press:.0f})")
    if isfinite(found.vision_error_mm):
        errors = f"position off by {found.vision_error_mm:.2f} mm, diameter by {found.diameter_error:.1%} (95 %)"
        lines.append(f"vision: {errors}; {counted(found.false_detections, 'false detection')}")
    return lines


def known(value: float, digits: int) -> str:
    """Return a number with some digits; empty where it is none."""
    return f"{value:.{digits}f}" if isfinite(value) else ""
