"""Exploded views: parts moved along the direction in which they are put in place, until each is clear of the others."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.blanks import outer_points
from layflat.solids.shapes import PartPlace

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Literal

    from layflat.arrays import Array
    from layflat.solids.component import Component
    from layflat.solids.shapes import Shape

    Direction = Literal["", "out", "in", "side", "head", "tail", "+y", "-y", "+z", "-z"]

GAP_SHARE = 0.06  # distance between moved parts over the size of all
FIXED_HEADINGS = {"+y": (0.0, 1.0, 0.0), "-y": (0.0, -1.0, 0.0), "+z": (0.0, 0.0, 1.0), "-z": (0.0, 0.0, -1.0)}


@dataclass(frozen=True)
class Moving:
    """Component of a step, and the direction from which it comes.

    Directions are in the joint's frame: along z away from the middle ("out") or from there ("in"), sideways along x,
    along an axis, or that of a screw's head or tip; empty: it stays.
    """

    component: Component
    direction: Direction
    follows: str = ""  # name of a component of the step that takes it along
    block: str = ""  # components of one block move as one


def corners(shape: Shape, at: PartPlace) -> Array:
    """Return the corners of the box around a shape at a place, mm, (8, 3)."""
    points = outer_points(shape)
    local = np.array(list(product(*zip(points.min(axis=0), points.max(axis=0), strict=True))))
    moved: Array = at.origin + local @ at.axes.T
    return moved


def explode(there: Sequence[Component], moving: Sequence[Moving]) -> list[tuple[PartPlace, ...]]:
    """Return the places of moving components, in their order.

    Args:
        there: components that stay.
        moving: components in the order in which they are put in place; each clears those before it.
    """
    placed = [corners(one.shape, at) for one in there for at in one.places]
    everything = [*placed, *(corners(one.component.shape, at) for one in moving for at in one.component.places)]
    gap = GAP_SHARE * float(np.ptp(np.vstack(everything), axis=0).max())
    shifts: dict[str, list[Array]] = {}
    lengths: dict[str, list[float]] = {}
    found = []
    for one in moving:
        component, leader = one.component, shifts.get(one.follows)
        count = component.quantity
        bases = [leader[k * len(leader) // count] if leader else np.zeros(3) for k in range(count)]
        parts = [corners(component.shape, at) + base for at, base in zip(component.places, bases, strict=True)]
        headings = _headings(one, parts)
        if one.block:
            if one.block not in lengths:
                lengths[one.block] = [
                    _block_length([other for other in moving if other.block == one.block], placed, gap)
                ]
            moved = [lengths[one.block][0] * heading for heading in headings]
        else:
            moved = _clear(parts, headings, placed, gap)
        shifts[component.name] = [base + shift for base, shift in zip(bases, moved, strict=True)]
        placed.extend(part + shift for part, shift in zip(parts, moved, strict=True))
        places = zip(component.places, shifts[component.name], strict=True)
        found.append(tuple(PartPlace(at.axes, at.origin + shift) for at, shift in places))
    return found


def _headings(moving: Moving, parts: Sequence[Array]) -> list[Array]:
    """Return the unit vector along which each part of a component moves, (3,); 0 for moving that stays."""
    return [_heading(moving.direction, part, at) for part, at in zip(parts, moving.component.places, strict=True)]


def _heading(direction: Direction, at: Array, place: PartPlace) -> Array:
    """Return the unit vector of a direction for a part with corners (8, 3) at a place, (3,)."""
    middle = at.mean(axis=0)
    match direction:
        case "":
            return np.zeros(3)
        case "out" | "in":
            return np.array([0.0, 0.0, (1.0 if middle[2] >= 0 else -1.0) * (1.0 if direction == "out" else -1.0)])
        case "side":
            return np.array([1.0 if middle[0] >= 0 else -1.0, 0.0, 0.0])
        case "head" | "tail":
            return np.array(place.axes[:, 2]) * (1.0 if direction == "head" else -1.0)
        case _:
            return np.array(FIXED_HEADINGS[direction])


def _clear(parts: Sequence[Array], headings: Sequence[Array], placed: Sequence[Array], gap: float) -> list[Array]:
    """Return the shifts by which parts clear others; parts at one level along one heading move by one length."""
    rows = [
        (*map(float, np.round(heading, 3)), round(float((part @ heading).max()), 1))
        for part, heading in zip(parts, headings, strict=True)
    ]
    lengths: dict[tuple[float, ...], float] = {}
    for row, part, heading in zip(rows, parts, headings, strict=True):
        lengths[row] = max(lengths.get(row, 0.0), _clear_length(part, heading, placed, gap))
    return [lengths[row] * heading for row, heading in zip(rows, headings, strict=True)]


def _block_length(members: Sequence[Moving], placed: Sequence[Array], gap: float) -> float:
    """Return the length by which a block of components moves to clear all that lies in its path, mm."""
    longest = 0.0
    for one in members:
        parts = [corners(one.component.shape, at) for at in one.component.places]
        for part, heading in zip(parts, _headings(one, parts), strict=True):
            longest = max(longest, _clear_length(part, heading, placed, gap))
    return longest


def _clear_length(part: Array, heading: Array, placed: Sequence[Array], gap: float) -> float:
    """Return the length by which a part moves along a heading to clear all that lies in its path, mm."""
    if not heading.any():
        return 0.0
    across = np.linalg.svd(heading[None])[2][1:]
    low, high = (part @ across.T).min(axis=0), (part @ across.T).max(axis=0)
    length = 0.0
    for other in placed:
        aside = other @ across.T
        if (aside.max(axis=0) > low).all() and (aside.min(axis=0) < high).all():
            length = max(length, float((other @ heading).max() - (part @ heading).min()) + gap)
    return length
