"""Solids of shapes by a CAD kernel; lengths in mm. Needs the extra `cad`."""

from __future__ import annotations

from math import tau
from typing import TYPE_CHECKING, Any

from layflat.solids.kernel import integrals, kernel, pieces, placed
from layflat.solids.loops import ArcSide, CurveSide, StraightSide
from layflat.solids.shapes import Drilled, Joined, Lofted, Prism, Shape, Turned

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from layflat.solids.loops import Loop
    from layflat.solids.shapes import Vector

SPLINE_TOLERANCE = 1e-6  # below which points of a curve are one, mm


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
            return _combined(kernel().BRepAlgoAPI.BRepAlgoAPI_Fuse(), first, others)


def _prism(shape: Prism) -> Any:
    gp, build = kernel().gp, kernel().BRepBuilderAPI
    inner = [_wire(opening) for opening in shape.openings]
    for hole in shape.holes:
        circle = gp.gp_Circ(_axes((*hole.centre, 0.0), (0.0, 0.0, 1.0)), hole.diameter / 2)
        inner.append(build.BRepBuilderAPI_MakeWire(build.BRepBuilderAPI_MakeEdge(circle).Edge()).Wire())
    body = _extruded(_face(_wire(shape.outline), inner), shape.height)
    cuts = [_lifted(_extruded(_face(_wire(loop)), high - low), low) for loop, low, high in shape.pockets]
    return _drill(body, shape.drilled, cuts)


def _turned(shape: Turned) -> Any:
    gp, making = kernel().gp, kernel().BRepPrimAPI
    axis = gp.gp_Ax1(gp.gp_Pnt(0.0, 0.0, 0.0), gp.gp_Dir(0.0, 0.0, 1.0))
    return _only_solid(making.BRepPrimAPI_MakeRevol(_face(_wire(shape.outline, "xz")), axis, tau, True).Shape())


def _lofted(shape: Lofted) -> Any:
    k = kernel()
    through = k.BRepOffsetAPI.BRepOffsetAPI_ThruSections(True, True)  # a solid, of straight lines
    for section in shape.sections:
        polygon = k.BRepBuilderAPI.BRepBuilderAPI_MakePolygon()
        for point in (*section, section[0]):
            polygon.Add(k.gp.gp_Pnt(*map(float, point)))
        through.AddWire(polygon.Wire())
    through.Build()
    return _only_solid(through.Shape())


def _drill(body: Any, holes: Iterable[Drilled], others: Iterable[Any] = ()) -> Any:
    """Return a solid less drilled holes and other solids."""
    making, tools = kernel().BRepPrimAPI, list(others)
    for hole in holes:
        axes = _axes(hole.start, hole.direction)
        tools.append(_only_solid(making.BRepPrimAPI_MakeCylinder(axes, hole.diameter / 2, hole.depth, tau).Shape()))
    return _combined(kernel().BRepAlgoAPI.BRepAlgoAPI_Cut(), body, tools)


def _combined(operation: Any, body: Any, tools: Sequence[Any]) -> Any:
    """Return the largest solid of a Boolean operation between a solid and others, with one face a surface."""
    if not tools:
        return body
    k = kernel()
    for give, bodies in ((operation.SetArguments, [body]), (operation.SetTools, tools)):
        shapes = k.collections.List_TopoDS_Shape()
        for one in bodies:
            shapes.Append(one)
        give(shapes)
    operation.SetRunParallel(True)
    operation.Build()
    upgrade = k.ShapeUpgrade.ShapeUpgrade_UnifySameDomain(operation.Shape(), True, True, True)
    upgrade.AllowInternalEdges(False)
    upgrade.Build()
    found = list(pieces(upgrade.Shape(), "SOLID"))
    return found[0] if len(found) == 1 else max(found, key=lambda one: integrals(one).volume)


def _extruded(face: Any, height: float) -> Any:
    """Return the solid of a face that is moved along z."""
    k = kernel()
    return _only_solid(k.BRepPrimAPI.BRepPrimAPI_MakePrism(face, k.gp.gp_Vec(0.0, 0.0, height)).Shape())


def _lifted(body: Any, height: float) -> Any:
    """Return a solid that is moved along z."""
    move = kernel().gp.gp_Trsf()
    move.SetTranslation(kernel().gp.gp_Vec(0.0, 0.0, height))
    return body.Moved(kernel().TopLoc.TopLoc_Location(move))


def _only_solid(shape: Any) -> Any:
    return kernel().TopoDS.TopoDS.Solid(shape)


def _axes(origin: Vector, direction: Vector) -> Any:
    """Return the kernel's axes at a point, of which the third has a direction."""
    gp = kernel().gp
    return gp.gp_Ax3(gp.gp_Pnt(*map(float, origin)), gp.gp_Dir(*map(float, direction))).Ax2()


def _face(outline: Any, openings: Iterable[Any] = ()) -> Any:
    """Return the flat face within a wire less those within others."""
    k = kernel()

    def mended(wire: Any) -> Any:
        mending = k.ShapeFix.ShapeFix_Shape(wire)
        mending.Perform()
        return k.TopoDS.TopoDS.Wire(mending.Shape())

    making = k.BRepBuilderAPI.BRepBuilderAPI_MakeFace(mended(outline), True)
    for opening in openings:
        making.Add(mended(opening))
    mending = k.ShapeFix.ShapeFix_Face(making.Face())
    mending.FixOrientation()
    mending.Perform()
    return k.TopoDS.TopoDS.Face(mending.Result())


def _wire(loop: Loop, plane: str = "xy") -> Any:
    """Return a wire of a loop in the plane xy, or in xz for turned parts."""
    k = kernel()

    def point(p: tuple[float, float]) -> Any:
        x, y = float(p[0]), float(p[1])
        return k.gp.gp_Pnt(x, y, 0.0) if plane == "xy" else k.gp.gp_Pnt(x, 0.0, y)

    edges, before = k.collections.List_TopoDS_Shape(), loop.start
    for side in loop.sides:
        match side:
            case StraightSide(to):
                curve: tuple[Any, ...] = (point(before), point(to))
            case ArcSide(via, to):
                curve = (k.GC.GC_MakeArcOfCircle(point(before), point(via), point(to)).Value(),)
            case CurveSide(through):
                curve = (_spline([point(before), *map(point, through)]),)
        edges.Append(k.BRepBuilderAPI.BRepBuilderAPI_MakeEdge(*curve).Edge())
        before = side.end
    making = k.BRepBuilderAPI.BRepBuilderAPI_MakeWire()
    making.Add(edges)
    return making.Wire()


def _spline(points: Sequence[Any]) -> Any:
    """Return a smooth curve through points."""
    k = kernel()
    row = k.collections.HArray1_gp_Pnt(1, len(points))
    for number, point in enumerate(points, 1):
        row.SetValue(number, point)
    through = k.GeomAPI.GeomAPI_Interpolate(row, False, SPLINE_TOLERANCE)
    through.Perform()
    return through.Curve()
