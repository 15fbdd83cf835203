"""The CAD kernel, Open CASCADE: places, pieces, integrals and boxes of its shapes; lengths in mm.

Needs the extra `cad`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from layflat import extras
from layflat.lazy import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from layflat.arrays import Array
    from layflat.solids.shapes import PartPlace

ROOM_NAME = "solids"


def kernel() -> Any:
    """Return the bindings of the CAD kernel, which has a module a package; raise MissingExtraError without them."""
    return extras.import_extra("cad", "OCP", ROOM_NAME)


def placed(body: Any, at: PartPlace) -> Any:
    """Return a shape at a place; it shares its geometry and its triangles with the original."""
    gp = kernel().gp
    origin, x, z = ([float(value) for value in vector] for vector in (at.origin, at.axes[:, 0], at.axes[:, 2]))
    move = gp.gp_Trsf()
    move.SetTransformation(gp.gp_Ax3(gp.gp_Pnt(*origin), gp.gp_Dir(*z), gp.gp_Dir(*x)))
    return body.Moved(kernel().TopLoc.TopLoc_Location(move.Inverted()))


class Integrals(NamedTuple):
    """Integrals over a solid of density 1."""

    volume: float  # mm3
    centre: Array  # mm, (3,)
    inertia: Array  # about the centre, mm5, (3, 3)


def integrals(body: Any) -> Integrals:
    """Return volume, centre and inertia of a solid."""
    k = kernel()
    found = k.GProp.GProp_GProps()
    k.BRepGProp.BRepGProp.VolumeProperties_s(body, found)
    centre, inertia = found.CentreOfMass(), found.MatrixOfInertia()
    rows = [[inertia.Value(row, column) for column in (1, 2, 3)] for row in (1, 2, 3)]
    return Integrals(float(found.Mass()), np.array([centre.X(), centre.Y(), centre.Z()]), np.array(rows))


def box(body: Any) -> Array:
    """Return the least and greatest coordinates of a shape, (2, 3), whose triangles, which may reach out, are lost."""
    k = kernel()
    found = k.Bnd.Bnd_Box()
    k.BRepTools.BRepTools.Clean_s(body)
    k.BRepBndLib.BRepBndLib.AddOptimal_s(body, found)
    ends = found.CornerMin(), found.CornerMax()
    return np.array([[end.X(), end.Y(), end.Z()] for end in ends])


def pieces(body: Any, kind: Literal["SOLID", "FACE", "EDGE"]) -> Iterator[Any]:
    """Yield the solids, faces or edges of a shape."""
    k = kernel()
    cast = getattr(k.TopoDS.TopoDS, kind.capitalize())
    found = k.TopExp.TopExp_Explorer(body, getattr(k.TopAbs, f"TopAbs_{kind}"))
    while found.More():
        yield cast(found.Current())
        found.Next()
