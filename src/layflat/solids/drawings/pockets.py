"""Pockets of parts such as tubes: windows and slots that cut through a wall; mm."""

from __future__ import annotations

from math import atan2, cos, degrees, radians, sin
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.drawings.table import number_text
from layflat.solids.loops import ArcSide

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.drawings.flat import FlatPart
    from layflat.solids.loops import Loop


CLIP_STEP = 0.5  # between points by which hidden outlines are clipped, mm


def pieces_inside(part: FlatPart, loop: Loop) -> list[Array]:
    """Return the pieces (n, 2) of a loop that lie in the material of a pattern."""
    from matplotlib.path import Path  # noqa: PLC0415

    points = loop.points()
    corners = np.vstack((points, points[:1]))
    steps = np.diff(corners, axis=0)
    dense = np.vstack([
        start + step * np.linspace(0.0, 1.0, max(2, int(np.hypot(*step) / CLIP_STEP)), endpoint=False)[:, None]
        for start, step in zip(corners, steps, strict=False)
    ])  # fmt: skip
    inside = Path(part.outline.points()).contains_points(dense)
    for opening in part.openings:
        inside &= ~Path(opening.points()).contains_points(dense)
    ends = np.flatnonzero(np.diff(np.r_[False, inside, False].astype(int)))
    return [dense[first:last] for first, last in zip(ends[::2], ends[1::2], strict=True) if last - first > 1]


def pocket_reach(part: FlatPart, loop: Loop, along: int) -> tuple[float, float, bool]:
    """Return from where to where along an axis a pocket takes material, and whether it opens the outline.

    Args:
        part: the pattern.
        loop: outline of the pocket.
        along: the axis, 0 or 1.
    """
    from matplotlib.path import Path  # noqa: PLC0415

    points = part.outline.points()
    opened = points[Path(loop.points()).contains_points(points)]
    reach = np.concatenate([piece[:, along] for piece in (*pieces_inside(part, loop), opened)])
    return float(reach.min()), float(reach.max()), len(opened) > 0


def pocket_notes(part: FlatPart) -> list[str]:
    """Return a line for each pocket: from where to where along z, and its edges in the plan."""
    return [
        f"{_shape(part, loop)}, z from {number_text(low, 1)} to {number_text(high, 1)}."
        for loop, low, high in part.pockets
    ]


def _shape(part: FlatPart, loop: Loop) -> str:
    """Return the words for a pocket: a window by the directions of its edges, or a slot by its width."""
    from matplotlib.path import Path  # noqa: PLC0415

    if any(isinstance(side, ArcSide) for side in loop.sides):
        pieces = pieces_inside(part, loop)
        angles = sorted({round(degrees(atan2(*piece.mean(axis=0)[::-1])), 2) for piece in pieces})
        first, last = angles[0], angles[-1]
        middle, reach = radians((first + last) / 2), float(np.hypot(*pieces[0].mean(axis=0)))
        if not Path(loop.points()).contains_point((reach * cos(middle), reach * sin(middle))):
            first, last = last, first
        return f"Window from {first:g}° to {last:g}° (anticlockwise from x, dashed)"
    width, height = np.ptp(loop.points(), axis=0)
    return f"Slot {number_text(float(min(width, height)), 1)} wide (dashed)"
