"""What came of runs as numbers: one row a pick, and the figures that growers ask for."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
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
    """Figures of any number of picks; not a number where nothing was picked or seen."""

    picks: int
    correct: int  # of these, in the chosen place, and of its kind and grade
    overlooked: int  # fruit left in trays that were worked off, though a free place takes it
    seconds_a_pick: float  # all images and ways home included
    picks_a_minute: float  # likewise
    release_error_mm: float  # placement error, of the fruit's middle in its place as it is released, 95th percentile
    release_error_worst_mm: float
    peak_acceleration: float  # of any picked fruit, m/s^2
    press: float  # greatest force of the cup, N
    collisions: int  # of arm, lift or cup with what they should not touch
    air: float  # normal litres a pick, of joints, lift and cup
    vision_error_mm: float  # of fruit in trays, 95th percentile over all images
    diameter_error: float  # share, 95th percentile
    false_detections: int  # of known kinds where no such fruit is, in all images


def summary(deliveries: Iterable[Delivery]) -> Summary:
    """Return figures of deliveries."""
    all_of = list(deliveries)
    picks = [pick for delivery in all_of for pick in delivery.picks]
    verdicts = [verdict for delivery in all_of for verdict in delivery.verdicts]
    errors = [1e3 * verdict.release_error for verdict in verdicts]
    each = sum(delivery.time for delivery in all_of) / len(picks) if picks else nan
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
        vision_error_mm=1e3 * _quantile([error for one in all_of for error in one.vision.positions]),
        diameter_error=_quantile([error for one in all_of for error in one.vision.diameters]),
        false_detections=sum(one.vision.false for one in all_of),
    )


def as_dict(cell: Cell, runs: Sequence[Run], *, partial: bool = False) -> dict[str, Any]:
    """Return runs in a cell as plain numbers and texts, fit for JSON: SI units but where a name says otherwise.

    `partial` says whether more was asked for than was done.
    """
    return {
        "partial": partial,
        "cell": cell.origin,
        "machine": cell.machine.origin,
        "limits": {"acceleration": cell.limits.acceleration, "press": cell.limits.press},
        "summary": _plain(asdict(summary(delivery for run in runs for delivery in run.deliveries))),
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
        "truth": _plain(asdict(verdict)),
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
