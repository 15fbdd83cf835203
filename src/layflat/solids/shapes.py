"""Shapes of parts, as workshops make them: cut from plate or tube, turned, or laid through sections; lengths in mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from layflat.lazy import numpy as np

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.loops import Loop, Point

Vector = tuple[float, float, float]


class Hole(NamedTuple):
    """Round hole through a flat part, along its thickness."""

    centre: Point
    diameter: float
    thread: str = ""  # such as "M5"; its diameter is then that of the drill


class Drilled(NamedTuple):
    """Round hole from a point of the surface in any direction."""

    start: Vector
    direction: Vector  # of length 1, into the part
    diameter: float
    depth: float
    thread: str = ""


@dataclass(frozen=True)
class Prism:
    """Outline extruded along z, from 0 to a height."""

    outline: Loop
    height: float
    holes: tuple[Hole, ...] = ()
    openings: tuple[Loop, ...] = ()  # through the whole height
    drilled: tuple[Drilled, ...] = ()
    pockets: tuple[tuple[Loop, float, float], ...] = ()  # outline, and from where to where along z material is missing


@dataclass(frozen=True)
class Turned:
    """Outline of radius and height, rotated about z."""

    outline: Loop
    drilled: tuple[Drilled, ...] = ()


@dataclass(frozen=True)
class Lofted:
    """Solid through closed sections, each a polygon of as many corners as the others, with straight lines between."""

    sections: tuple[tuple[Vector, ...], ...]
    drilled: tuple[Drilled, ...] = ()


class PartPlace(NamedTuple):
    """Position and orientation of a part in the frame of a joint or an arm."""

    axes: Array  # columns: the part's axes, (3, 3)
    origin: Array  # mm, (3,)

    def then(self, outer: PartPlace) -> PartPlace:
        """Return this place, which is given in a frame, in the frame in which that one has a place."""
        return PartPlace(outer.axes @ self.axes, outer.origin + outer.axes @ self.origin)


@dataclass(frozen=True)
class Joined:
    """Shapes in one piece, each at its place: (axes by rows, origin) in the part's frame."""

    pieces: tuple[tuple[Prism | Turned, Vector, tuple[Vector, Vector, Vector]], ...]

    def placed(self) -> list[tuple[Prism | Turned, PartPlace]]:
        """Return the pieces with their places."""
        return [(piece, PartPlace(np.array(axes), np.array(origin))) for piece, origin, axes in self.pieces]


Shape = Prism | Turned | Lofted | Joined


def joined(*pieces: tuple[Prism | Turned, PartPlace]) -> Joined:
    """Return shapes at places in one piece."""
    rows = []
    for piece, at in pieces:
        axes = tuple(tuple(float(v) for v in row) for row in at.axes)
        rows.append((piece, tuple(float(v) for v in at.origin), axes))
    return Joined(tuple(rows))  # type: ignore[arg-type]


def place(x: float = 0.0, y: float = 0.0, z: float = 0.0, axes: Array | None = None) -> PartPlace:
    """Return a place.

    Args:
        x: coordinate of its origin, mm.
        y: the same.
        z: the same.
        axes: columns: its axes, (3, 3); default: those of the frame.
    """
    return PartPlace(np.eye(3) if axes is None else axes, np.array([x, y, z], float))


def turn_about_z(angle: float, about: Point = (0.0, 0.0)) -> PartPlace:
    """Return the rotation by an angle (rad) about an axis along z through a point, as a place."""
    c, s = float(np.cos(angle)), float(np.sin(angle))
    axes, centre = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array([*about, 0.0])
    return PartPlace(axes, centre - axes @ centre)


ALONG_X = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # a part's own x, y, z lie along y, z, x
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])  # rotated about x by half a turn
