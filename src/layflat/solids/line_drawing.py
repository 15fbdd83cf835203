"""Line drawings of solids with hidden lines removed, as SVG with numbered balloons; lengths in mm.

Lines are found on the triangles of the solids by the CAD kernel (polyhedral hidden-line removal).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from layflat.lazy import numpy as np
from layflat.solids.kernel import kernel, pieces
from layflat.solids.meshes import triangulate

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from layflat.arrays import Array

Point = tuple[float, float]

SMOOTH_ANGLE = 0.6  # angle between faces below which their common edge is not drawn, rad
WIDTH = 860.0  # of a picture, px
MAX_HEIGHT = 780.0  # px
SIDE_MARGIN = 74.0  # at both sides for balloons, px
EDGE_MARGIN = 12.0  # above and below, px
BALLOON_RADIUS = 15.0  # radius, px


@dataclass
class DrawnBody:
    """Solid in a drawing, at its place: from `placed`."""

    shape: Any
    number: int = 0  # of its balloon; 0: none
    faint: bool = False  # drawn in grey: it is there already
    lines: list[tuple[Point, Point]] = field(default_factory=list)  # that are visible, mm


def prepare(solid: Any) -> None:
    """Give a solid, and all copies of it at other places, the triangles that drawings need; bends become smooth."""
    kernel().BRepLib.BRepLib.EncodeRegularity_s(solid, SMOOTH_ANGLE)
    triangulate(solid)


def find_lines(bodies: Sequence[DrawnBody], view: tuple[float, float, float]) -> None:
    """Find the visible lines of bodies that have triangles.

    Args:
        bodies: to draw; their lines are set.
        view: direction from the bodies to the eye; z is up.
    """
    gp, hiding = kernel().gp, kernel().HLRBRep
    right = np.cross((0.0, 0.0, 1.0), view)
    right = right / np.linalg.norm(right)
    hidden = hiding.HLRBRep_PolyAlgo()
    for body in bodies:
        hidden.Load(body.shape)
    axes = gp.gp_Ax2(gp.gp_Pnt(0.0, 0.0, 0.0), gp.gp_Dir(*view), gp.gp_Dir(*map(float, right)))
    hidden.Projector(kernel().HLRAlgo.HLRAlgo_Projector(axes))
    hidden.Update()
    shapes = hiding.HLRBRep_PolyHLRToShape()
    shapes.Update(hidden)
    for body in bodies:
        for compound in (shapes.VCompound(body.shape), shapes.OutLineVCompound(body.shape)):
            body.lines.extend(_segments(compound))


def _segments(compound: Any) -> Iterable[tuple[Point, Point]]:
    """Yield the ends of the straight edges of a compound, which may be None."""
    if compound is None or compound.IsNull():
        return
    point, explore = kernel().BRep.BRep_Tool.Pnt_s, kernel().TopExp.TopExp
    for edge in pieces(compound, "EDGE"):
        first, last = point(explore.FirstVertex_s(edge)), point(explore.LastVertex_s(edge))
        yield (first.X(), first.Y()), (last.X(), last.Y())


def draw(bodies: Sequence[DrawnBody], title: str) -> str:
    """Return bodies with their lines as an SVG: new ones black with balloons, those that are there already grey.

    Args:
        bodies: after `find_lines`.
        title: that readers of the page hear.
    """
    ends = np.array([point for body in bodies for line in body.lines for point in line])
    low, high = ends.min(axis=0), ends.max(axis=0)
    scale = min((WIDTH - 2 * SIDE_MARGIN) / (high[0] - low[0]), (MAX_HEIGHT - 2 * EDGE_MARGIN) / (high[1] - low[1]))
    height = (high[1] - low[1]) * scale + 2 * EDGE_MARGIN
    shift = (WIDTH - (high[0] - low[0]) * scale) / 2

    def pixels(points: Array) -> Array:
        placed: Array = np.array([shift, height - EDGE_MARGIN]) + (points - low) * scale * [1.0, -1.0]
        return placed

    lines = {
        faint: np.array([line for body in bodies if body.faint is faint for line in body.lines]).reshape(-1, 2, 2)
        for faint in (True, False)
    }
    paths = {faint: _path(pixels(ends)) for faint, ends in lines.items()}
    found = _anchors(bodies)
    anchors = dict(zip(found, map(tuple, pixels(np.array([*found.values()]).reshape(-1, 2)).tolist()), strict=True))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:.0f} {height:.0f}" role="img" fill="none">'
        f"<title>{title}</title>"
        f'<path transform="scale(.1)" stroke="#999" stroke-width="7" d="{paths[True]}"/>'
        f'<path transform="scale(.1)" stroke="#000" stroke-width="11" stroke-linecap="round" d="{paths[False]}"/>'
        f"{_balloons(anchors, height)}</svg>"
    )


def _anchors(bodies: Sequence[DrawnBody]) -> dict[int, Point]:
    """Return a visible point of each numbered body: on its first body, the middle of the line nearest to its middle."""
    anchors: dict[int, Point] = {}
    for body in bodies:
        if not body.number or body.number in anchors or not body.lines:
            continue
        middles = np.array(body.lines).mean(axis=1)
        centre = (middles.min(axis=0) + middles.max(axis=0)) / 2
        x, y = middles[int(np.argmin(np.hypot(*(middles - centre).T)))]
        anchors[body.number] = (float(x), float(y))
    return anchors


def _path(lines: Array) -> str:
    """Return lines (px, (n, 2, 2)) as a path in tenths of a pixel, joined where one goes on from another."""
    tenths = [((a, b), (x, y)) for (a, b), (x, y) in np.rint(10 * lines).astype(int).tolist()]
    rounded = list(dict.fromkeys(line for line in tenths if line[0] != line[1]))
    ends: dict[tuple[int, ...], list[int]] = {}
    for k, line in enumerate(rounded):
        for end in line:
            ends.setdefault(end, []).append(k)
    left, parts = set(range(len(rounded))), []
    for k, chain in enumerate(map(list, rounded)):
        if k not in left:
            continue
        left.discard(k)
        while (following := next((j for j in ends[chain[-1]] if j in left), None)) is not None:
            left.discard(following)
            chain.append(rounded[following][rounded[following][0] == chain[-1]])
        steps = "".join(f" {x - a:d} {y - b:d}" for (a, b), (x, y) in pairwise(chain))
        parts.append(f"M{chain[0][0]} {chain[0][1]}l{steps[1:]}".replace(" -", "-"))
    return "".join(parts)


def _balloons(anchors: dict[int, Point], height: float) -> str:
    """Return balloons at both sides, in the order of their anchors from the top: no leaders cross."""
    order = sorted(anchors, key=lambda number: anchors[number][0])
    parts = []
    for side, numbers in ((0, order[: len(order) // 2]), (1, order[len(order) // 2 :])):
        column = sorted(numbers, key=lambda number: anchors[number][1])
        x = (BALLOON_RADIUS + 2, WIDTH - BALLOON_RADIUS - 2)[side]
        for number, y in zip(column, _spread([anchors[n][1] for n in column], height), strict=True):
            ax, ay = anchors[number]
            inner = x + (BALLOON_RADIUS if side == 0 else -BALLOON_RADIUS)
            parts.append(
                f'<path stroke="#000" stroke-width="0.6" d="M{inner:.1f} {y:.1f}L{ax:.1f} {ay:.1f}"/>'
                f'<circle cx="{ax:.1f}" cy="{ay:.1f}" r="2.2" fill="#000"/>'
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{BALLOON_RADIUS:g}" stroke="#000" fill="#fff"/>'
                f'<text x="{x:.1f}" y="{y + 5:.1f}" fill="#000" font-size="14" font-family="sans-serif"'
                f' text-anchor="middle">{number}</text>'
            )
    return "".join(parts)


def _spread(heights: Sequence[float], limit: float) -> Array:
    """Return ascending heights moved so that balloons at them do not touch and stay below a limit, px."""
    apart = 2 * BALLOON_RADIUS + 4
    count = len(heights)
    apart = min(apart, (limit - 2 * BALLOON_RADIUS - 2) / max(count - 1, 1))
    found = np.array(heights, float)
    for k in range(count):
        found[k] = max(found[k], BALLOON_RADIUS + 1 if k == 0 else found[k - 1] + apart)
    for k in reversed(range(count)):
        found[k] = min(found[k], limit - BALLOON_RADIUS - 1 if k == count - 1 else found[k + 1] - apart)
    return found
