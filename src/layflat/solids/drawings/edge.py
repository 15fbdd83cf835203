"""Views of flat parts from their edge; mm."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Any

from layflat.lazy import numpy as np
from layflat.solids.drawings.pockets import pocket_reach
from layflat.solids.drawings.views import draw_drilled

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.drawings.flat import FlatPart
    from layflat.solids.drawings.views import View
    from layflat.solids.loops import Loop

CORNER_TURN = 0.35  # turn of an outline above which its corner is an edge in the side view, rad


def draw_side(view: View, part: FlatPart, *, below: bool) -> None:
    """Draw a pattern from its edge: from the left, placed on the right of the plan, or from above, placed below it.

    Args:
        view: where; its origin is that of the part.
        part: the pattern.
        below: whether it is placed below.
    """
    (low, high), along = part.box, 0 if below else 1
    t = part.thickness

    def flat(lengths: Any, heights: Any) -> Array:
        return np.stack((lengths, -np.asarray(heights)) if below else (heights, lengths), axis=-1)

    a, b = low[along], high[along]
    view.line(flat([a, b, b, a], [0.0, 0.0, t, t]), "outline", closed=True)
    for edge in _visible_corners(part.outline, along):
        view.line(flat([edge, edge], [0.0, t]), "outline")
    for loop, first, last in part.pockets:
        least, most, opens = pocket_reach(part, loop, along)
        view.line(
            flat([least, most, most, least], [first, first, last, last]), "outline" if opens else "hidden", closed=True
        )
    for hole in part.drilled:
        draw_drilled(view, hole, (0, 2) if below else (2, 1), (1, -1) if below else (1, 1))


def _visible_corners(loop: Loop, along: int) -> list[float]:
    """Return where along an axis an outline has corners that are seen from its side."""
    points = loop.points()
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    turn = np.abs((np.arctan2(*after.T[::-1]) - np.arctan2(*before.T[::-1]) + pi) % (2 * pi) - pi)
    across = points[:, 1 - along]
    found = []
    for corner in np.flatnonzero(turn > CORNER_TURN):
        # Seen from the left (or from above), what hides a corner lies at smaller x (or larger y).
        beside = np.abs(points[:, along] - points[corner, along]) < 1.0
        nearest = across[beside].min() if along == 1 else -(-across[beside]).min()
        if abs(nearest - across[corner]) < 1.0:
            found.append(float(points[corner, along]))
    return found
