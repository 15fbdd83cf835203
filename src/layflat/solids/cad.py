"""Solids of shapes by a CAD kernel; lengths in mm. Needs the extra `cad`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from layflat import extras
from layflat.solids.loops import ArcSide, CurveSide, StraightSide
from layflat.solids.shapes import Drilled, Joined, Lofted, PartPlace, Prism, Shape, Turned

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from layflat.solids.loops import Loop

ROOM_NAME = "solids"


def kernel() -> Any:
    """Return the module of the CAD kernel; raise MissingExtraError without the extra `cad`."""
    return extras.import_extra("cad", "build123d", ROOM_NAME)


def solid(shape: Shape) -> Any:
    """Return the solid of a shape in its own frame."""
    match shape:
        case Prism():
            return _prism(shape)
        case Turned():
            return _drill(_turned(shape), shape.drilled)
        case Lofted():
            return _drill(_lofted(shape), shape.drilled)
        case Joined():
            first, *others = [placed(solid(piece), at) for piece, at in shape.placed()]
            return _largest(first.fuse(*others).solids()) if others else first


def placed(body: Any, at: PartPlace) -> Any:
    """Return a copy of a solid at a place; it shares its geometry with the original."""
    return type(body)(body.wrapped.Moved(location(at).wrapped))  # the kernel's own `moved` copies the geometry first


def location(at: PartPlace) -> Any:
    """Return the kernel's location of a place."""
    b = kernel()
    x, _, z = at.axes.T
    return b.Location(b.Plane(origin=tuple(at.origin), x_dir=tuple(x), z_dir=tuple(z)))


def wire(loop: Loop, plane: str = "xy") -> Any:
    """Return a wire of a loop in the plane xy, or in xz for turned parts."""
    b = kernel()

    def point(p: tuple[float, float]) -> tuple[float, float, float]:
        return (p[0], p[1], 0.0) if plane == "xy" else (p[0], 0.0, p[1])

    edges, before = [], loop.start
    for side in loop.sides:
        match side:
            case StraightSide(to):
                edges.append(b.Edge.make_line(point(before), point(to)))
            case ArcSide(via, to):
                edges.append(b.Edge.make_three_point_arc(point(before), point(via), point(to)))
            case CurveSide(through):
                edges.append(b.Edge.make_spline([point(before), *map(point, through)]))
        before = side.end
    return b.Wire(edges)


def _prism(shape: Prism) -> Any:
    b = kernel()
    inner = [wire(opening) for opening in shape.openings]
    inner += [b.Wire.make_circle(hole.diameter / 2, b.Plane((*hole.centre, 0.0))) for hole in shape.holes]
    body = b.Solid.extrude(b.Face(wire(shape.outline), inner), b.Vector(0.0, 0.0, shape.height))
    cuts = [
        b.Solid.extrude(b.Face(wire(loop)), b.Vector(0.0, 0.0, high - low)).moved(b.Location((0.0, 0.0, low)))
        for loop, low, high in shape.pockets
    ]
    return _drill(body, shape.drilled, cuts)


def _turned(shape: Turned) -> Any:
    b = kernel()
    return b.Solid.revolve(b.Face(wire(shape.outline, "xz")), 360.0, b.Axis.Z)


def _lofted(shape: Lofted) -> Any:
    b = kernel()
    return b.Solid.make_loft([b.Wire.make_polygon(section, close=True) for section in shape.sections], ruled=True)


def _drill(body: Any, holes: Iterable[Drilled], others: Iterable[Any] = ()) -> Any:
    """Return a solid less drilled holes and other solids."""
    b = kernel()
    tools = list(others)
    for hole in holes:
        plane = b.Plane(origin=hole.start, z_dir=hole.direction)
        tools.append(b.Solid.make_cylinder(hole.diameter / 2, hole.depth, plane))
    if not tools:
        return body
    cut = body.cut(*tools)
    return _largest(cut.solids() if hasattr(cut, "solids") else [cut])


def _largest(bodies: Sequence[Any]) -> Any:
    """Return the solid with the most volume."""
    return bodies[0] if len(bodies) == 1 else max(bodies, key=lambda one: one.volume)
