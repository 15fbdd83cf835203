"""From a detected fruit to the grade by which it is packed, or why it has none.

A skin is identified by its chromaticity, r and g of r + g + b = 1, which light and shade leave alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.file.produce import Produce, Skin
from layflat.cell.plan.fruit import Fruit
from layflat.cell.vision import Detection

DIAMETER_ERROR = 0.015
"""By which vision may be off, share: about the worst of 1800 fruit, see docs/cell-vision.md."""
TINT = 0.01
"""By which a chromaticity may be off: lights of unlike tint."""
AS_NEAR = 0.6
"""Ratio of two skins' distances from which they are about as near."""
UNKNOWN = "unknown"
"""Kind of an unknown object, which stands in the way all the same."""


def fruit_of(cell: Cell, detection: Detection) -> Fruit:
    """Return a fruit as plans know it, with its grade, or with the doubt that leaves it without one.

    Args:
        cell: its produce says what grades there are.
        detection: of vision.
    """
    produce = cell.produce.get(detection.kind) if detection.kind is not None else None
    if detection.kind is None or produce is None:
        return _doubtful(detection, "is of no kind that is known here")
    skin = _skin(produce.colour, detection.colour)
    if skin.doubt:
        return _doubtful(detection, f"could be {skin.name} or {skin.doubt}")
    grades = _grades(produce, detection.diameter, skin.name)
    if len(grades) > 1:
        names = " or ".join(grade or "none" for grade in grades)
        return _doubtful(
            detection, f"is too near to a limit: {1e3 * detection.diameter:.1f} mm may be of grade {names}"
        )
    (grade,) = grades
    if grade is None:
        return _doubtful(detection, f"is of no grade: {skin.name}, {1e3 * detection.diameter:.0f} mm")
    return _fruit(detection, detection.kind, grade)


@dataclass(frozen=True)
class _Skin:
    """The nearest skin, and another that is about as near, if one is."""

    name: str
    doubt: str = ""


def _skin(skins: Mapping[str, Skin], colour: tuple[float, float, float]) -> _Skin:
    seen = _chromaticity(colour)
    away = {name: float(np.linalg.norm(seen - _chromaticity(skin.rgb))) / _wide(skin) for name, skin in skins.items()}
    nearest, *others = sorted(away, key=lambda name: away[name])
    if others and away[nearest] > AS_NEAR * away[others[0]]:
        return _Skin(nearest, others[0])
    return _Skin(nearest)


def _wide(skin: Skin) -> float:
    """Return how far chromaticities of a skin are from its mean, one standard deviation with what light adds."""
    return float(np.hypot(0.5 * skin.spread / sum(skin.rgb), TINT))


def _chromaticity(colour: tuple[float, float, float]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.array(colour[:2]) / max(sum(colour), 1e-6)


def _grades(produce: Produce, diameter: float, colour: str) -> list[str | None]:
    """Return the grades that a fruit may have, as far as its diameter is known."""
    low, high = diameter * (1.0 - DIAMETER_ERROR), diameter * (1.0 + DIAMETER_ERROR)
    limits = [limit for grade in produce.grade.values() for limit in (grade.least, grade.most) if low < limit <= high]
    return list(dict.fromkeys(produce.grade_of(at, colour) for at in (low, *sorted(limits))))


def _doubtful(detection: Detection, doubt: str) -> Fruit:
    return replace(_fruit(detection, detection.kind or UNKNOWN, ""), doubt=doubt)


def _fruit(detection: Detection, kind: str, grade: str) -> Fruit:
    x, y, _ = detection.position
    return Fruit(x, y, detection.diameter, kind, grade, detection.confidence)
