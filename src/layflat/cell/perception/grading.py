"""From a detected fruit to the grade by which it is packed, or why it has none.

A skin is identified by its chromaticity, r and g of r + g + b = 1, which light and shade leave alone.
"""

from collections.abc import Mapping

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.file.produce import Produce, Skin
from layflat.cell.geometry import Array
from layflat.cell.plan.fruit import Fruit
from layflat.cell.vision import Detection

DIAMETER_ERROR = 0.015  # by which vision may be off, share: about the worst of 1800 fruit, see docs/cell-vision.md
TINT = 0.01  # by which a chromaticity may be off: lights of unlike tint
AS_NEAR = 0.6  # ratio of two skins' distances from which they are about as near
UNKNOWN = "unknown"  # kind of an unknown object, which stands in the way all the same


def fruit_of(cell: Cell, detection: Detection) -> Fruit:
    """Return a detected fruit as plans know it, with its grade or the doubt that leaves it none."""
    grade, doubt = _graded(cell, detection)
    x, y, _ = detection.position
    return Fruit(x, y, detection.diameter, detection.kind or UNKNOWN, grade, detection.confidence, doubt)


def _graded(cell: Cell, detection: Detection) -> tuple[str, str]:
    """Return the grade, and the doubt as a clause; one of them is empty."""
    if detection.kind is None or detection.kind not in cell.produce:
        return "", "is of no kind that is known here"
    produce, diameter = cell.produce[detection.kind], detection.diameter
    skin, other = _skins(produce.colour, detection.colour)
    if other:
        return "", f"could be {skin} or {other}"
    grades = _grades(produce, diameter, skin)
    if len(grades) > 1:
        names = " or ".join(grade or "none" for grade in grades)
        return "", f"is too near to a limit: {1e3 * diameter:.1f} mm may be of grade {names}"
    return (grades[0], "") if grades[0] else ("", f"is of no grade: {skin}, {1e3 * diameter:.0f} mm")


def _skins(skins: Mapping[str, Skin], colour: tuple[float, float, float]) -> tuple[str, str]:
    """Return the nearest skin, in units of its spread with what light adds, and another about as near, if one is."""
    seen = _chromaticity(colour)
    wide = {name: float(np.hypot(0.5 * skin.spread / sum(skin.rgb), TINT)) for name, skin in skins.items()}
    away = {name: float(np.linalg.norm(seen - _chromaticity(skin.rgb))) / wide[name] for name, skin in skins.items()}
    nearest, *others = sorted(away, key=lambda name: away[name])
    return nearest, others[0] if others and away[nearest] > AS_NEAR * away[others[0]] else ""


def _chromaticity(colour: tuple[float, float, float]) -> Array:
    return np.array(colour[:2]) / max(sum(colour), 1e-6)


def _grades(produce: Produce, diameter: float, colour: str) -> list[str | None]:
    """Return the grades that a fruit may have, as far as its diameter is known."""
    low, high = diameter * (1.0 - DIAMETER_ERROR), diameter * (1.0 + DIAMETER_ERROR)
    limits = [limit for grade in produce.grade.values() for limit in (grade.least, grade.most) if low < limit <= high]
    return list(dict.fromkeys(produce.grade_of(at, colour) for at in (low, *sorted(limits))))
