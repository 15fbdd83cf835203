"""What came of runs as numbers: one row a pick, and the figures that growers ask for."""

import json
from collections.abc import Iterable, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.work.records import Delivery, Pick, Verdict
from layflat.cell.work.run import Run
from layflat.files import write_text


class Summary:
    """Figures of the picks in any number of deliveries; not a number where nothing was picked or seen."""

    def __init__(self, deliveries: Iterable[Delivery]) -> None:
        all_of = list(deliveries)
        picks = [pick for delivery in all_of for pick in delivery.picks]
        verdicts = [verdict for delivery in all_of for verdict in delivery.verdicts]
        errors = [1e3 * verdict.release_error for verdict in verdicts]
        each = sum(delivery.time for delivery in all_of) / len(picks) if picks else nan
        self.picks = len(picks)
        # In the chosen place, and of its kind and grade.
        self.correct = sum(verdict.correct for verdict in verdicts)
        # Fruit left in trays that were worked off, though a free place takes it.
        self.overlooked = sum(delivery.overlooked or 0 for delivery in all_of)
        # All images and ways home included.
        self.seconds_a_pick, self.picks_a_minute = each, 60.0 / each if picks else nan
        # Of the fruit's middle in its place as it is released, 95th percentile and greatest.
        self.release_error_mm, self.release_error_worst_mm = _quantile(errors), _greatest(errors)
        # Of any picked fruit, m/s^2; greatest force of the cup, N.
        self.peak_acceleration = _greatest([verdict.peak_acceleration for verdict in verdicts])
        self.press = _greatest([verdict.press for verdict in verdicts])
        # Of arm, lift or cup with what they should not touch.
        self.collisions = sum(len(delivery.collisions) for delivery in all_of)
        # Of joints, lift and cup, normal litres a pick.
        self.air = sum(pick.air for pick in picks) / len(picks) if picks else nan
        # Of fruit in trays, over all images: 95th percentiles, the second as a share; known kinds where there are none.
        self.vision_error_mm = 1e3 * _quantile([error for one in all_of for error in one.vision.positions])
        self.diameter_error = _quantile([error for one in all_of for error in one.vision.diameters])
        self.false_detections = sum(one.vision.false for one in all_of)


def as_dict(cell: Cell, runs: Sequence[Run], *, partial: bool = False) -> dict[str, Any]:
    """Return runs, `partial` if more was asked for, as numbers and texts for JSON: SI units unless names say else."""
    return {
        "partial": partial,
        "cell": cell.origin,
        "machine": cell.machine.origin,
        "limits": {"acceleration": cell.limits.acceleration, "press": cell.limits.press},
        "summary": _plain(vars(Summary(delivery for run in runs for delivery in run.deliveries))),
        "runs": [
            {
                "seed": run.seed,
                "perception": "scene" if run.calibration is None else "camera",
                "error": str(run.error) if run.error is not None else None,
                "deliveries": [_delivery(delivery) for delivery in run.deliveries],
            }
            for run in runs
        ],
    }


def save(content: dict[str, Any], path: Path) -> Path:
    """Write results; raise OutputError where they can't be."""
    return write_text(path, json.dumps(content, indent=1))


def _delivery(delivery: Delivery) -> dict[str, Any]:
    return {
        "seed": delivery.seed,
        "time": delivery.time,
        "error": str(delivery.error) if delivery.error is not None else None,
        "overlooked": delivery.overlooked,
        "picks": [_pick(pick, verdict) for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True)],
        "not_picked": [
            {"kind": fruit.kind, "grade": fruit.grade, "x": fruit.x, "y": fruit.y, "why": reason}
            for fruit, reason in delivery.not_picked
        ],
        "collisions": [collision._asdict() for collision in delivery.collisions],
    }


def _pick(pick: Pick, verdict: Verdict) -> dict[str, Any]:
    fruit, place = pick.choice.fruit, pick.choice.place
    return {
        "number": pick.number,
        "seen": {name: getattr(fruit, name) for name in ("kind", "grade", "diameter", "confidence", "x", "y")},
        "container": place.container,
        "place": place.name,
        "outcome": pick.outcome.name.lower(),
        **{name: getattr(pick, name) for name in ("trouble", "tries", "begin", "end", "air")},
        "truth": _plain(vars(verdict)),
    }


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    """Return values as JSON can hold them: it has no nan."""
    return {key: None if isinstance(value, float) and not isfinite(value) else value for key, value in values.items()}


def counted(number: int, thing: str, things: str = "") -> str:
    """Return a number with its thing, in the plural (default: with an s) where it is not one."""
    return f"{number} {thing}" if number == 1 else f"{number} {things or thing + 's'}"


def _quantile(values: Sequence[float]) -> float:
    known = [value for value in values if isfinite(value)]
    return float(np.quantile(known, 0.95)) if known else nan


def _greatest(values: Sequence[float]) -> float:
    return max((value for value in values if isfinite(value)), default=nan)
