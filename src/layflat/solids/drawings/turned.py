"""Views of turned parts: in section along their axis, with diameters and lengths; mm."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from layflat.lazy import numpy as np
from layflat.solids.drawings.table import number_text
from layflat.solids.drawings.views import draw_drilled
from layflat.solids.loops import StraightSide

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.drawings.table import Fits
    from layflat.solids.drawings.views import View
    from layflat.solids.shapes import Turned

CHAIN_STEP = 9.0  # between dimension lines, mm on the paper
FIRST_OFFSET = 9.0  # of the first dimension line from the part
FACE_GAP = 1e-3  # by which a point is beside a face, mm
IN_PLANE = 1e-6  # of a hole's direction across the section


class Face(NamedTuple):
    """Cylindrical face of a turned part."""

    radius: float
    low: float
    high: float
    bore: bool


def faces(shape: Turned) -> list[Face]:
    """Return the cylindrical faces of a turned part, along its axis."""
    from matplotlib.path import Path  # noqa: PLC0415

    outline = Path(shape.outline.points())
    found, start = [], shape.outline.start
    for side in shape.outline.sides:
        (r, z), (r_2, z_2) = start, side.end
        if isinstance(side, StraightSide) and abs(r - r_2) < FACE_GAP and r > FACE_GAP:
            bore = bool(outline.contains_point((r + FACE_GAP, (z + z_2) / 2)))
            found.append(Face(r, min(z, z_2), max(z, z_2), bore))
        start = side.end
    return sorted(found, key=lambda face: (face.low, face.bore))


def hollow(shape: Turned) -> bool:
    """Return whether a turned part has something inside that a section shows."""
    return bool(shape.drilled) or any(face.bore for face in faces(shape))


def draw_turned(view: View, shape: Turned) -> None:
    """Draw a turned part with its axis along x of the view: in section if it is hollow, else from outside."""
    profile = shape.outline.points()[:, ::-1]  # z, r
    ends = profile[:, 0].min(), profile[:, 0].max()
    if hollow(shape):
        for half in _cut_areas(profile):
            view.paper.area([view.paper_points(half)], "outline", "hatched")
            view.labels.avoid(view.paper_points(np.vstack((half, half[:1]))))
        for face in faces(shape):
            if face.bore:
                for z in (face.low, face.high):
                    view.line([(z, -face.radius), (z, face.radius)], "outline")
    else:
        for z in sorted({float(z) for z in profile[:, 0]}):
            r = float(profile[profile[:, 0] == z, 1].max())
            view.line([(z, -r), (z, r)], "outline")
        for face in faces(shape):
            for side in (-1, 1):
                view.line([(face.low, side * face.radius), (face.high, side * face.radius)], "outline")
    for hole in shape.drilled:
        flat = abs(hole.direction[1]) < IN_PLANE and abs(hole.start[1]) < hole.diameter / 2
        if flat:
            view.paper.area(
                [view.paper_points(_walls(hole.start, hole.direction, hole.diameter, hole.depth))], "none", "white"
            )
        draw_drilled(view, hole, (2, 0), pen="outline" if flat else "hidden")
    beyond = 3.0 / view.scale
    view.paper.line(view.paper_points([(ends[0] - beyond, 0.0), (ends[1] + beyond, 0.0)]), "centre")
    for number, hole in enumerate(shape.drilled, 1):
        x, _, z = hole.start
        out = np.array([-hole.direction[2], -hole.direction[0]])
        view.labels.place(view.paper_points((z, x)) + out, 0.0, str(number))


def _cut_areas(profile: Array) -> list[Array]:
    """Return the areas that a section cuts of a profile (n, 2), z and r: two halves, or one if it is solid."""
    mirror = np.array([1.0, -1.0])
    off_axis = profile[:, 1] > FACE_GAP
    if off_axis.all():
        return [profile, profile * mirror]
    first = int(np.argmax(off_axis & ~np.roll(off_axis, 1)))
    outer = np.roll(profile, -first, axis=0)
    outer = outer[outer[:, 1] > FACE_GAP]
    return [np.vstack((outer, outer[::-1] * mirror))]


def _walls(start: tuple[float, ...], direction: tuple[float, ...], diameter: float, depth: float) -> Array:
    """Return the corners of a hole in the plane of the section: z, x."""
    first, along = np.array([start[2], start[0]]), np.array([direction[2], direction[0]])
    across = diameter / 2 * np.array([-along[1], along[0]])
    last = first + depth * along
    return np.array([first + across, last + across, last - across, first - across])


def diameter_label(face: Face, fits: Fits, designation: str) -> str:
    """Return the text of a face's diameter, with its tolerance.

    Args:
        face: the face.
        fits: of the assembly.
        designation: of the stock, such as "ground bar 10 h6".
    """
    size = 2 * face.radius
    if face.bore:
        fit = fits.of_bore(size)
        return f"Ø{number_text(fits.nominal(size), 1)}{' ' + fit if fit else ''}"
    ground = "h6" in designation.split() and any(abs(one - size) < FACE_GAP for one in fits.shafts)
    return f"Ø{number_text(size, 1)}{' h6' if ground else ''}"


def draw_sizes(view: View, shape: Turned, fits: Fits, designation: str) -> None:
    """Dimension diameters beside a turned part and lengths below it.

    Args:
        view: where.
        shape: the part.
        fits: of the assembly.
        designation: of the stock.
    """
    all_faces = faces(shape)
    low, high = min(face.low for face in all_faces), max(face.high for face in all_faces)
    left, right = sides_of(all_faces)
    for group, end, out in ((left, low, -1.0), (right, high, 1.0)):
        for k, face in enumerate(group):
            z = face.low if out < 0 else face.high
            offset = out * ((abs(end - z)) * view.scale + FIRST_OFFSET + k * CHAIN_STEP)
            view.distance(
                (z, -face.radius), (z, face.radius), offset, diameter_label(face, fits, designation), upright=True
            )
    radius = max(face.radius for face in all_faces)
    cuts = sorted({round(z, 6) for face in all_faces if not face.bore for z in (face.low, face.high)})
    if len(cuts) > 2:
        for one, other in pairwise(cuts):
            view.distance((one, -radius), (other, -radius), -FIRST_OFFSET, number_text(other - one, 1))
    view.distance(
        (low, -radius),
        (high, -radius),
        -FIRST_OFFSET - (CHAIN_STEP if len(cuts) > 2 else 0.0),
        number_text(high - low, 1),
    )


def _leftwards(face: Face, all_faces: list[Face], middle: float) -> bool:
    """Return whether a face is dimensioned on the left: a larger one is on its right, or it is a bore there."""
    if face.bore:
        return (face.low + face.high) / 2 < middle and min(one.low for one in all_faces) > face.low - FACE_GAP
    larger = [one for one in all_faces if not one.bore and one.radius > face.radius]
    return any(one.low >= face.low for one in larger) and not any(one.low < face.low for one in larger)


def sides_of(all_faces: list[Face]) -> tuple[list[Face], list[Face]]:
    """Return the faces that are dimensioned on the left and on the right, each size once, smaller ones first."""
    unique: dict[tuple[float, bool], Face] = {}
    for face in all_faces:
        unique.setdefault((round(face.radius, 3), face.bore), face)
    low, high = min(face.low for face in all_faces), max(face.high for face in all_faces)
    left = [face for face in unique.values() if _leftwards(face, all_faces, (low + high) / 2)]
    right = [face for face in unique.values() if face not in left]
    key = lambda face: face.radius  # noqa: E731
    return sorted(left, key=key), sorted(right, key=key)
