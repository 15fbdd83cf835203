"""Results of runs as numbers and text: a row for each pick, figures of merit, failures."""

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.plan.order import Fruit
from layflat.cell.work.observer import Delivery, Pick, Verdict
from layflat.cell.work.run import PackingRun
from layflat.files import write_text

COLUMNS = ("pick", "fruit", "mm", "place", "result", "error (mm)", "peak (m/s2)", "s", "air (Nl)")
"""Column heads of `pick_row`."""


class PackingSummary:
    """Figures of merit of the picks in any number of deliveries; nan where nothing was picked or detected."""

    def __init__(self, deliveries: Iterable[Delivery]) -> None:
        """Compute the figures of all deliveries."""
        all_of = list(deliveries)
        picks = [pick for delivery in all_of for pick in delivery.picks]
        verdicts = [verdict for delivery in all_of for verdict in delivery.verdicts]
        errors = [1e3 * verdict.release_error for verdict in verdicts]
        each = sum(delivery.time for delivery in all_of) / len(picks) if picks else nan
        self.picks = len(picks)
        # In the chosen place, and of its kind and grade.
        self.correct = sum(verdict.correct for verdict in verdicts)
        # Fruit left in finished trays, though a free place accepts it.
        self.overlooked = sum(delivery.overlooked or 0 for delivery in all_of)
        # All images and ways home included.
        self.seconds_a_pick, self.picks_a_minute = each, 60.0 / each if picks else nan
        # Of the fruit's middle in its place as it is released, 95th percentile and greatest.
        self.release_error_mm, self.release_error_worst_mm = _quantile_95(errors), _max_finite(errors)
        # Greatest of all picked fruit, m/s^2, and greatest force of the cup, N.
        self.peak_acceleration = _max_finite([verdict.peak_acceleration for verdict in verdicts])
        self.press = _max_finite([verdict.press for verdict in verdicts])
        # Collisions of arm, lift or cup.
        self.collisions = sum(len(delivery.collisions) for delivery in all_of)
        # Of joints, lift and cup, normal litres a pick.
        self.air = sum(pick.air for pick in picks) / len(picks) if picks else nan
        # Of fruit in trays, over all images: 95th percentiles, the second as a share; known kinds where there are none.
        self.vision_error_mm = 1e3 * _quantile_95([error for one in all_of for error in one.vision.positions])
        self.diameter_error = _quantile_95([error for one in all_of for error in one.vision.diameters])
        self.false_detections = sum(one.vision.false for one in all_of)


def record_runs(cell: Cell, runs: Sequence[PackingRun], *, partial: bool = False) -> dict[str, Any]:
    """Return the results of runs for JSON: numbers and texts, in SI units unless a key names another.

    Keys: `partial`, `cell`, `machine`, `limits`, `summary` (attributes of `PackingSummary`), and `runs`, a list with
    `seed`, `perception` ("scene" or "camera"), `error` and `deliveries`. None stands for numbers
    that are not finite; air is in normal litres.

    Args:
        cell: description.
        runs: results.
        partial: whether more picks were requested.
    """
    return {
        "partial": partial,
        "cell": cell.origin,
        "machine": cell.machine.origin,
        "limits": {"acceleration": cell.limits.acceleration, "press": cell.limits.contact_force},
        "summary": _json_values(vars(PackingSummary(delivery for run in runs for delivery in run.deliveries))),
        "runs": [
            {
                "seed": run.seed,
                "perception": "scene" if run.calibration is None else "camera",
                "error": str(run.error) if run.error is not None else None,
                "deliveries": [_delivery_record(delivery) for delivery in run.deliveries],
            }
            for run in runs
        ],
    }


def save_results(content: dict[str, Any], path: Path) -> Path:
    """Write results as JSON, and return the path; raise OutputError if they can't be written."""
    return write_text(path, json.dumps(content, indent=1))


def _delivery_record(delivery: Delivery) -> dict[str, Any]:
    """Return a delivery for JSON: seed, time (s), error, overlooked, picks, not_picked and collisions."""
    return {
        "seed": delivery.seed,
        "time": delivery.time,
        "error": str(delivery.error) if delivery.error is not None else None,
        "overlooked": delivery.overlooked,
        "picks": [_pick_record(pick, verdict) for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True)],
        "not_picked": [
            {"kind": fruit.kind, "grade": fruit.grade, "x": fruit.x, "y": fruit.y, "why": reason}
            for fruit, reason in delivery.not_picked
        ],
        "collisions": [collision._asdict() for collision in delivery.collisions],
    }


def _pick_record(pick: Pick, verdict: Verdict) -> dict[str, Any]:
    """Return a pick for JSON: its fruit as `seen`, place, outcome and records, and its verdict as `truth`."""
    fruit, place = pick.choice.fruit, pick.choice.place
    return {
        "number": pick.number,
        "seen": {name: getattr(fruit, name) for name in ("kind", "grade", "diameter", "confidence", "x", "y")},
        "container": place.container,
        "place": place.name,
        "outcome": pick.outcome.name.lower(),
        **{name: getattr(pick, name) for name in ("trouble", "tries", "begin", "end", "air")},
        "truth": _json_values(vars(verdict)),
    }


def _json_values(values: dict[str, Any]) -> dict[str, Any]:
    """Return values with None in place of numbers that are not finite, which JSON lacks."""
    return {key: None if isinstance(value, float) and not isfinite(value) else value for key, value in values.items()}


def count_noun(number: int, thing: str, things: str = "") -> str:
    """Return a number with its noun, in the plural where it is not 1.

    Args:
        number: count.
        thing: noun in the singular.
        things: noun in the plural; default: with an s.
    """
    return f"{number} {thing}" if number == 1 else f"{number} {things or thing + 's'}"


def _quantile_95(values: Sequence[float]) -> float:
    """Return the 95th percentile of the finite values; nan where there are none."""
    finite = [value for value in values if isfinite(value)]
    return float(np.quantile(finite, 0.95)) if finite else nan


def _max_finite(values: Sequence[float]) -> float:
    """Return the greatest of the finite values; nan where there are none."""
    return max((value for value in values if isfinite(value)), default=nan)


def pick_row(name: str, pick: Pick, verdict: Verdict) -> tuple[str, ...]:
    """Return the table row of a pick, by `COLUMNS`.

    Args:
        name: name of the pick, such as "2.5": the fifth of the second delivery.
        pick: its record.
        verdict: its evaluation.
    """
    fruit, place = pick.choice.fruit, pick.choice.place
    cells = name, sort_name(fruit), f"{1e3 * fruit.diameter:.0f}", f"{place.container} {place.name}", verdict.word(pick)
    errors = format_finite(1e3 * verdict.release_error, 1), format_finite(verdict.peak_acceleration, 0)
    return (*cells, *errors, f"{pick.end - pick.begin:.2f}", f"{pick.air:.1f}")


def sort_name(fruit: Fruit) -> str:
    """Return kind and grade of a fruit, such as "tomato, A"; the kind alone without a grade."""
    return f"{fruit.kind}, {fruit.grade}" if fruit.grade else fruit.kind


def describe_trouble(name: str, pick: Pick) -> str:
    """Return one line about the failure of a pick; empty where there was none."""
    if not pick.trouble:
        return ""
    return f"pick {name}, {pick.outcome.name.lower()}, {count_noun(pick.tries, 'try', 'tries')}: {pick.trouble}"


def count_reasons(reasons: Iterable[str]) -> list[str]:
    """Return a line for each reason with the number of fruit that were not picked for it."""
    return [f"{count} not picked: {reason}" for reason, count in Counter(reasons).items()]


def summary_lines(cell: Cell, deliveries: Iterable[Delivery]) -> list[str]:
    """Return lines of text with the figures of merit of all picks; none where nothing was picked."""
    figures, limits = PackingSummary(deliveries), cell.limits
    if not figures.picks:
        return []
    share = f"{figures.correct / figures.picks:.1%}"
    picks, collisions = count_noun(figures.picks, "pick"), count_noun(figures.collisions, "collision")
    lines = [
        f"{figures.correct} of {picks} correct: in the chosen place, of its kind and grade ({share})",
        f"{figures.picks_a_minute:.1f} picks a minute, {figures.air:.1f} normal litres of air each",
    ]
    if isfinite(figures.release_error_mm):
        worst = figures.release_error_worst_mm
        lines.append(f"placement error: {figures.release_error_mm:.1f} mm (95 %), {worst:.1f} mm at most")
    lines.append(f"{collisions}; {figures.overlooked} overlooked that could have been packed")
    if isfinite(figures.peak_acceleration):
        peak = f"{figures.peak_acceleration:.0f} m/s2 at most (limit {limits.acceleration:.0f})"
        lines.append(f"fruit: {peak}, pressed by {figures.press:.0f} N at most (limit {limits.contact_force:.0f})")
    if isfinite(figures.vision_error_mm):
        errors = f"position off by {figures.vision_error_mm:.2f} mm, diameter by {figures.diameter_error:.1%} (95 %)"
        lines.append(f"vision: {errors}; {count_noun(figures.false_detections, 'false detection')}")
    return lines


def format_finite(value: float, digits: int) -> str:
    """Return a number with a number of decimals; empty where it is not finite."""
    return f"{value:.{digits}f}" if isfinite(value) else ""
