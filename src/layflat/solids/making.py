"""Walls, holes and bends of the parts that a workshop makes, by the rules of their processes."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

from layflat.design.summary import Finding
from layflat.lazy import numpy as np
from layflat.solids.section import CrossSection
from layflat.solids.shapes import Joined, Prism
from layflat.solids.sizes import MM
from layflat.solids.standard.processes import PROCESSES, check_bend, check_hole, check_wall

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from layflat.solids.component import Component
    from layflat.solids.shapes import Hole
    from layflat.solids.sizes import JointSizes

SHEET_PROCESSES = ("laser cutting", "bending")
SHELL_MATERIAL = "aluminium-sheet"
MAX_STRAP_MISS = 0.1  # of the strap's line from the shell's strap point, mm


def making_findings(parts: Sequence[Component], joints: Mapping[str, JointSizes]) -> list[Finding]:
    """Return findings about walls, holes and bends of components, and of joints by label, that can't be made."""
    found: list[Finding | None] = []
    for one in parts:
        if one.making in PROCESSES:
            shapes = [piece for piece, _ in one.shape.placed()] if isinstance(one.shape, Joined) else [one.shape]
            where = f"{one.joint}: {one.name}"
            for shape in shapes:
                if isinstance(shape, Prism):
                    found += _flat_findings(one, shape, where)
    for name, sizes in joints.items():
        found += [*_bend_findings(sizes, name), strap_finding(sizes, name)]
    return list(dict.fromkeys(one for one in found if one is not None))


def strap_finding(sizes: JointSizes, name: str) -> Finding | None:
    """Return a warning if the strap's line leaves the strap point of the laws by more than 0.1 mm, else None."""
    miss = CrossSection(sizes).strap_miss
    if miss <= MAX_STRAP_MISS:
        return None
    what = f"the strap's line misses the strap point by {miss:.3g} mm over the stroke"
    right = f"{MAX_STRAP_MISS:g} mm are allowed; a thinner strap bends over a smaller nose: change strap.thickness"
    return Finding("warning", "strap path", f"{name}: strap", what, right)


def _flat_findings(component: Component, shape: Prism, where: str) -> list[Finding | None]:
    """Return findings about a part that is cut from plate, or a piece of one; `where` is joint and part.

    Holes that a cut can't make are drilled after it.
    """
    name, thickness = component.making, shape.height / MM
    sheet = name in SHEET_PROCESSES
    tool = "milling" if sheet else name
    drilled: set[Hole] = set()
    found: list[Finding | None] = []
    for hole in shape.holes:
        if sheet and not hole.thread and check_hole(name, hole.diameter / MM, where, thickness):
            drilled.add(hole)
        found.append(check_hole(tool, hole.diameter / MM, f"{where}, hole at {_hole_text(hole)}", thickness))
    for holes, wall in _walls(shape):
        if sheet and check_wall(name, wall / MM, where, thickness):
            drilled |= {hole for hole in holes if not hole.thread}
        near = " at the hole at " + " and ".join(_hole_text(hole) for hole in holes) if holes else ""
        found.append(check_wall(tool, wall / MM, f"{where}, wall{near}"))
    if not sheet:
        found.append(check_wall(name, thickness, f"{where}, thickness"))
    if drilled:
        what = f"holes smaller, or nearer to an edge, than {name} makes them in {shape.height:g} mm: {len(drilled)}"
        found.append(Finding("note", "hole", where, what, "drill them after the cut"))
    return found


def _walls(shape: Prism) -> Iterator[tuple[tuple[Hole, ...], float]]:
    """Yield the holes beside it and the thickness (mm) of each wall: between holes, an edge, and openings."""
    for loop in shape.openings:
        yield (), min(shape.outline.distance(point) for point in loop.points())
    for hole in shape.holes:
        edge = min(loop.distance(hole.centre) for loop in (shape.outline, *shape.openings))
        yield (hole,), edge - hole.diameter / 2
    for one, other in combinations(shape.holes, 2):
        apart = float(np.hypot(one.centre[0] - other.centre[0], one.centre[1] - other.centre[1]))
        yield (one, other), apart - (one.diameter + other.diameter) / 2


def _hole_text(hole: Hole) -> str:
    """Return the place of a hole for messages."""
    return f"({hole.centre[0]:.3g}, {hole.centre[1]:.3g}) mm"


def _bend_findings(sizes: JointSizes, name: str) -> list[Finding | None]:
    """Return findings about the bends of a joint's shells: around the hose, and over the nose."""
    material = SHELL_MATERIAL
    shell = sizes.shell / MM
    nose = sizes.nose_radius / MM - shell
    around = (sizes.radius + sizes.hose_thickness) / MM
    return [
        check_bend(material, max(nose, 0.0), f"{name}: shell, nose below the strap", shell),
        check_bend(material, around, f"{name}: shell, around the hose", shell),
    ]
