"""The output's cams, or rollers, as parts: outlines with lugs for the rods that hold them together."""

from __future__ import annotations

from math import cos, pi, sin
from typing import TYPE_CHECKING

from layflat.design.cam import HUB_SHARE, Outline
from layflat.design.straplines import direction_vector, rotate_quarter
from layflat.errors import DesignError
from layflat.lazy import numpy as np
from layflat.solids.loops import CurveSide, Loop, StraightSide
from layflat.solids.shapes import Drilled, Hole, Prism
from layflat.solids.sizes import MM
from layflat.solids.standard.threads import THREADS

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.sizes import JointSizes

PROFILE_STEP = 1.0  # least distance between points of a profile that is drawn as a curve, mm
LUG_POINTS = 48
FLAT_SHARE = 0.5  # length of the strap's clamp over the smallest lever arm, as `Outline` has it
LEAST_FLAT = 7.0  # length of the strap's clamp, mm: a screw's head
CLAMP_SCREW = THREADS["M3"]  # of the straps' clamps
SCREW_DEPTH = 6.0  # of which these reach into cam or roller at most, mm
TAPPED_DEPTH = 8.0  # depth of their threads, mm


def winding(sizes: JointSizes) -> Array:
    """Return the line along which the strap winds up in a cam's own frame, mm, (n, 2), from its first point on.

    The last two points are the ends of the flat on which it is clamped.
    """
    cam = sizes.design.cam
    if cam is None:
        r = sizes.joint.output.radius * MM
        first = float(_roller_normal(sizes, 0.0))
        angles = np.linspace(first, first - sizes.stroke, 1 + int(np.degrees(sizes.stroke)))
        profile, end, length = r * direction_vector(angles), angles[-1], max(FLAT_SHARE * r, LEAST_FLAT)
    else:
        profile, end = cam.profile * MM, float(cam.normal[-1])
        length = max(FLAT_SHARE * float(cam.lever.min()) * MM, LEAST_FLAT)
    tangent = rotate_quarter(direction_vector(end))
    line: Array = np.vstack((profile, profile[-1] - length * tangent))
    return line


def _roller_normal(sizes: JointSizes, turn: float) -> float:
    """Return the angle of the normal of the strap's line on a roller that has turned by an angle, rad."""
    point = np.array(strap_point(sizes, turn)) - np.array([0.0, sizes.axis])
    distance = float(np.hypot(*point))
    r = sizes.joint.output.radius * MM
    return float(np.arctan2(point[1], point[0]) - np.arccos(r / distance)) % (2 * pi) - 2 * pi


def strap_point(sizes: JointSizes, turn: float) -> tuple[float, float]:
    """Return the shell's strap point, mm, once cam or roller has turned by an angle (rad) from the collapsed hose."""
    hinge, start = np.array(sizes.line.hinge) * MM, np.array(sizes.line.start) * MM
    angle = opening(sizes, turn)
    c, s = cos(angle), sin(angle)
    x, y = hinge + np.array([[c, -s], [s, c]]) @ (start - hinge)
    return float(x), float(y)


def opening(sizes: JointSizes, turn: float) -> float:
    """Return the angle (rad) by which the shell has opened once cam or roller has turned by an angle (rad).

    Beyond the ends of the stroke the shell goes on as fast as it moved there.
    """
    chord = sizes.line.chord
    if sizes.design.cam is None:
        return turn * sizes.joint.output.radius / chord
    cam = sizes.design.cam
    if turn < 0:
        return float(turn * cam.travel[1] / cam.angle[1]) / chord
    if turn > cam.stroke:
        slope = (cam.travel[-1] - cam.travel[-2]) / (cam.angle[-1] - cam.angle[-2])
        return float(cam.travel[-1] + (turn - cam.stroke) * slope) / chord
    return float(np.interp(turn, cam.angle, cam.travel)) / chord


def flat(sizes: JointSizes) -> tuple[Array, float]:
    """Return the middle of the strap's clamp in a cam's own frame, mm, (2,), and the angle of its normal, rad."""
    ends = winding(sizes)[-2:]
    along = ends[0] - ends[1]
    return ends.mean(axis=0), float(np.arctan2(along[1], along[0])) - pi / 2


def cam_part(sizes: JointSizes, width: float, screws: tuple[float, ...]) -> Prism:
    """Return a cam, or a roller, in its own frame, from 0 to its width along z.

    Args:
        sizes: sizes of the joint.
        width: along z, mm.
        screws: places of the screws of the strap's clamp along z, mm.

    Raises:
        DesignError: the cam is not convex, or leaves no wall around the shaft.
    """
    holes = tuple(Hole((float(x), float(y)), sizes.rod.clearance_hole * MM) for x, y in sizes.rod_points)
    (x, y), normal = flat(sizes)
    inward = (-cos(normal), -sin(normal), 0.0)
    drilled = tuple(
        Drilled((float(x), float(y), z), inward, CLAMP_SCREW.tapping_hole * MM, TAPPED_DEPTH, CLAMP_SCREW.name)
        for z in screws
    )  # fmt: skip
    return Prism(cam_loop(sizes), width, (Hole((0.0, 0.0), sizes.shaft), *holes), drilled=drilled)


def cam_loop(sizes: JointSizes) -> Loop:
    """Return the outline of a cam or roller: its profile as a curve, its back the hull of run-out, clamp, hub and lugs.

    Raises:
        DesignError: the cam is not convex, or leaves no wall around the shaft.
    """
    from scipy.spatial import ConvexHull  # noqa: PLC0415  # SciPy takes long to import

    line = winding(sizes)
    profile = line[-2::-1]
    ring = direction_vector(np.linspace(0.0, 2 * pi, LUG_POINTS, endpoint=False))
    lugs = [centre + sizes.lug_radius(sizes.rod) * ring for centre in sizes.rod_points]
    points = np.vstack((profile, line[-1:], _back(sizes), _screw_ends(sizes), *lugs))
    order = ConvexHull(points).vertices
    on_back = order >= len(profile)
    first = int(np.argmax(on_back & ~np.roll(on_back, 1)))
    back = points[np.roll(order, -first)][np.roll(on_back, -first)]
    (x, y), *rest = (tuple(map(float, point)) for point in _spaced(profile))
    curve = CurveSide(tuple((float(x), float(y)) for x, y in rest))
    return Loop((x, y), (curve, *(StraightSide((float(x), float(y))) for x, y in back), StraightSide((x, y))))


def _back(sizes: JointSizes) -> Array:
    """Return points of run-out and hub of a cam, or of a roller, mm, (n, 2)."""
    cam = sizes.design.cam
    if cam is None:
        radius = sizes.joint.output.radius * MM
        first = _roller_normal(sizes, 0.0)
        back: Array = radius * direction_vector(np.linspace(first, first + 2 * pi - sizes.stroke, 180)[1:-1])
        return back
    thickest = 2 * float(cam.lever.min()) * MM / HUB_SHARE
    if sizes.shaft >= thickest:
        what = f"a shaft of {sizes.shaft:g} mm leaves no wall with a lever arm of {cam.lever.min() * MM:.4g} mm"
        right = "a lower supply pressure, or a shorter stroke, leaves one"
        raise DesignError(what, where=f"{sizes.design.label}.output", right=right)
    outline = Outline(cam, sizes.shaft / MM)
    points: Array = outline.points[len(outline.profile) :] * MM
    return points


def _screw_ends(sizes: JointSizes) -> Array:
    """Return points beside the tips of the screws of the strap's clamp, mm, (2, 2)."""
    middle, normal = flat(sizes)
    aside = CLAMP_SCREW.diameter / 2 * MM * direction_vector(normal + pi / 2)
    tip = middle - SCREW_DEPTH * direction_vector(normal)
    points: Array = np.stack((tip - aside, tip + aside))
    return points


def _spaced(points: Array) -> Array:
    """Return points of a curve that are apart by `PROFILE_STEP` or more, with both ends."""
    kept = [0]
    for k in range(1, len(points) - 1):
        apart = np.hypot(*(points[k] - points[kept[-1]])), np.hypot(*(points[-1] - points[k]))
        if min(apart) >= PROFILE_STEP:
            kept.append(k)
    chosen: Array = points[[*kept, len(points) - 1]]
    return chosen
