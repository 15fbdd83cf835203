"""What came of runs as numbers: one row a pick, and the figures that growers ask for."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.work.records import Delivery, Pick, Verdict
from layflat.cell.work.run import Run
from layflat.files import whole_file

MINUTE = 60.0


@dataclass(frozen=True)
class Summary:
    """Figures of any number of picks.

    Attributes:
        picks: how many.
        correct: of these, in the chosen place, and of its kind and grade.
        seconds_a_pick: all images and ways home included.
        picks_a_minute: likewise.
        overlooked: fruit left in trays that were worked off, though a free place takes it.
        release_error_mm: placement error, of the fruit's middle in its place as it is released, 95th percentile.
        release_error_worst_mm: greatest.
        peak_acceleration: of any picked fruit, m/s^2.
        press: greatest force of the cup, N.
        collisions: of arm, lift or cup with what they should not touch.
        air: normal litres a pick, of joints, lift and cup.
        vision_error_mm: of fruit in trays, 95th percentile over all images.
        diameter_error: share, 95th percentile.
        false_detections: of known kinds where no such fruit is, in all images.
    """

    picks: int
    correct: int
    overlooked: int
    seconds_a_pick: float
    picks_a_minute: float
    release_error_mm: float
    release_error_worst_mm: float
    peak_acceleration: float
    press: float
    collisions: int
    air: float
    vision_error_mm: float
    diameter_error: float
    false_detections: int


def summary(deliveries: Iterable[Delivery]) -> Summary:
    """Return figures of deliveries; not a number where nothing was picked or seen."""
    all_of = list(deliveries)
    picks = [pick for delivery in all_of for pick in delivery.picks]
    verdicts = [verdict for delivery in all_of for verdict in delivery.verdicts]
    time = sum(delivery.time for delivery in all_of)
    errors = [1e3 * verdict.release_error for verdict in verdicts]
    each = time / len(picks) if picks else nan
    seen = [delivery.vision for delivery in all_of]
    return Summary(
        picks=len(picks),
        correct=sum(verdict.correct for verdict in verdicts),
        overlooked=sum(delivery.overlooked or 0 for delivery in all_of),
        seconds_a_pick=each,
        picks_a_minute=MINUTE / each if picks else nan,
        release_error_mm=_quantile(errors),
        release_error_worst_mm=_greatest(errors),
        peak_acceleration=_greatest([verdict.peak_acceleration for verdict in verdicts]),
        press=_greatest([verdict.press for verdict in verdicts]),
        collisions=sum(len(delivery.collisions) for delivery in all_of),
        air=sum(pick.air for pick in picks) / len(picks) if picks else nan,
        vision_error_mm=1e3 * _quantile([error for one in seen for error in one.positions]),
        diameter_error=_quantile([error for one in seen for error in one.diameters]),
        false_detections=sum(one.false for one in seen),
    )


def as_dict(cell: Cell, runs: Sequence[Run], *, partial: bool = False) -> dict[str, Any]:
    """Return runs in a cell as plain numbers and texts, fit for JSON: SI units but where a name says otherwise.

    Args:
        cell: its description.
        runs: what was done.
        partial: whether more was asked for than was done.
    """
    return {
        "partial": partial,
        "cell": cell.origin,
        "machine": cell.machine.origin,
        "limits": {"acceleration": cell.limits.acceleration, "press": cell.limits.press},
        "summary": _plain(vars(summary(delivery for run in runs for delivery in run.deliveries))),
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
    """Write results.

    Raises:
        OutputError: they can't be written there.
    """
    with whole_file(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1), encoding="utf-8")
    return path


def _delivery(delivery: Delivery) -> dict[str, Any]:
    return {
        "seed": delivery.seed,
        "time": delivery.time,
        "error": str(delivery.error) if delivery.error is not None else None,
        "overlooked": delivery.overlooked,
        "picks": [_pick(pick, verdict) for pick, verdict in zip(delivery.picks, delivery.verdicts, strict=True)],
        "not_picked": [
            {"kind": one.fruit.kind, "grade": one.fruit.grade, "x": one.fruit.x, "y": one.fruit.y, "why": one.reason}
            for one in delivery.not_picked
        ],
        "collisions": [vars(collision) for collision in delivery.collisions],
    }


def _pick(pick: Pick, verdict: Verdict) -> dict[str, Any]:
    fruit, place = pick.choice.fruit, pick.choice.place
    seen = {"kind": fruit.kind, "grade": fruit.grade, "diameter": fruit.diameter, "confidence": fruit.confidence}
    return {
        "number": pick.number,
        "seen": seen | {"x": fruit.x, "y": fruit.y},
        "container": place.container,
        "place": place.name,
        "outcome": pick.outcome.name.lower(),
        "trouble": pick.trouble,
        "tries": pick.tries,
        "begin": pick.begin,
        "end": pick.end,
        "air": pick.air,
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
