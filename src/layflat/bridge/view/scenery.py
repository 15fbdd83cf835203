"""Scene of an arm: its pieces by frame, upright, with a floor below; and viewpoints."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import atan, pi, radians, tan
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.bridge.pieces import Piece, axes_with_z, joint_pieces, link_pieces, rigid_arm
from layflat.machine import Machine
from layflat.physics.arms.bodies import RigidArm, rotation_about_axis

FLOOR_SQUARE = 0.1  # edge of a square of the floor, m
POST_DIAMETER_RATIO = 0.6  # diameter of the post below an arm over that of the body of its first joint
FLOOR_CLEARANCE = 0.02  # between a horizontal arm and the floor, m
ARC_STEP = radians(3.0)  # between points of arcs, rad
TIP_DIAMETER = 0.046  # diameter of the ball at the tip, m


@dataclass(frozen=True)
class Scenery:
    """Pieces that an arm is drawn by. Frames are those of the base (0), of the links, and of the tool (last)."""

    machine: Machine
    arm: RigidArm
    level: Array  # columns: axes of the base in the room, where gravity is along -z, (3, 3)
    pieces: tuple[tuple[int, Piece], ...]  # with the index of their frames
    floor: float  # its height, m

    def frames(self, angles: Sequence[float] | Array) -> list[tuple[Array, Array]]:
        """Return axes (3, 3) and origins (m, (3,)) of all frames in the room at angles (rad)."""
        poses = [(np.eye(3), np.zeros(3)), *self.arm.poses(angles)]
        return [(self.level @ axes, self.level @ origin) for axes, origin in poses]

    def placed(self, angles: Sequence[float] | Array) -> list[Piece]:
        """Return all pieces in the frame of the room at angles (rad)."""
        frames = self.frames(angles)
        return [place_piece(piece, *frames[frame]) for frame, piece in self.pieces]

    def tip(self, angles: Sequence[float] | Array) -> Array:
        """Return the position of the tip in the frame of the base at angles (rad), m, (3,)."""
        return self.arm.poses(angles)[-1][1]


def scenery(machine: Machine, angles: Sequence[float]) -> Scenery:
    """Return the scene of a machine's arm, with a floor below it at some angles (rad).

    The floor is at the height of the base, or below the arm where that is lower; then a post carries the first joint.

    Raises:
        InputError: the arm is of a kind without bodies, or a mesh is not there.
    """
    arm, bodies = rigid_arm(machine), joint_pieces(machine)
    pieces = [(i, piece) for i, of_link in enumerate(link_pieces(machine), 1) for piece in [*of_link, bodies[i - 1]]]
    pieces.append((len(arm.links) + 1, Piece("sphere", np.zeros(3), np.eye(3), (TIP_DIAMETER,), "tip")))
    bare = Scenery(machine, arm, _upright_axes(arm.gravity), tuple(pieces), 0.0)
    first = place_piece(bodies[0], *bare.frames(angles)[1])
    low = min(_lowest(piece) for piece in bare.placed(angles))
    floor = 0.0 if low >= 0.0 else low - FLOOR_CLEARANCE
    height = float(first.position[2]) - floor
    if height > FLOOR_CLEARANCE:
        foot = first.position - np.array([0.0, 0.0, 0.5 * height])
        post = Piece(
            "cylinder", bare.level.T @ foot, bare.level.T, (POST_DIAMETER_RATIO * bodies[0].size[0], height), "link"
        )
        pieces = [(0, post), *pieces]
    return replace(bare, pieces=tuple(pieces), floor=floor)


def place_piece(piece: Piece, axes: Array, origin: Array) -> Piece:
    """Return a piece of a frame in the parent frame.

    Args:
        piece: piece in its frame.
        axes: axes of that frame in the parent frame, (3, 3).
        origin: origin of that frame in the parent frame, m, (3,).
    """
    return replace(piece, position=origin + axes @ piece.position, axes=axes @ piece.axes)


def stroke_arcs(shown: Scenery, joint: int) -> tuple[Array, Array]:
    """Return segments (n, 2, 3), m, of arcs of a joint's working stroke, and of the ranges between it and the stops.

    They are in the frame before the joint, about the link in mid-stroke, with a dash at each stop.
    """
    link = shown.arm.links[joint]
    end = shown.arm.links[joint + 1].place if joint + 1 < len(shown.arm.links) else shown.arm.tool
    across = end - link.axis * (link.axis @ end)
    length = float(np.linalg.norm(across))
    radial = across / length if length > FLOOR_SQUARE else axes_with_z(link.axis)[:, 0]
    stops = list(shown.machine.joints.values())[joint].stops
    radius = max(0.4 * length, FLOOR_SQUARE)
    works, stop = 0.5 * stops.working_stroke, 0.5 * stops.mechanical_stroke
    inner = _arc(link.axis, radius * radial, -works, works)
    outer = [*_arc(link.axis, radius * radial, -stop, -works), *_arc(link.axis, radius * radial, works, stop)]
    dashes = [_dash(link.axis, radius * radial, angle) for angle in (-stop, stop)]
    return _to_parent_frame(link.axes, link.place, inner), _to_parent_frame(link.axes, link.place, [*outer, *dashes])


def _to_parent_frame(axes: Array, place: Array, segments: list[Array]) -> Array:
    """Return segments (n, 2, 3) in the parent frame, from those in a frame with these axes and this origin."""
    points: Array = np.array(segments).reshape(-1, 2, 3) @ axes.T + place
    return points


def _arc(axis: Array, arm: Array, begin: float, end: float) -> list[Array]:
    """Return the segments (2, 3) of an arc: `arm` rotated about an axis from `begin` to `end`, rad."""
    angles = np.linspace(begin, end, max(int(abs(end - begin) / ARC_STEP) + 1, 2))
    points = [rotation_about_axis(axis, angle) @ arm for angle in angles]
    return [np.array(pair) for pair in pairwise(points)]


def _dash(axis: Array, arm: Array, angle: float) -> Array:
    """Return the segment (2, 3) across an arc at an angle, rad."""
    out = rotation_about_axis(axis, angle) @ arm
    return np.array([0.9 * out, 1.1 * out])


def _upright_axes(gravity: Array) -> Array:
    """Return the base's axes (columns) in a room where gravity (m/s2) is along -z; without gravity the identity."""
    strength = float(np.linalg.norm(gravity))
    up = -gravity / strength if strength > 0.0 else np.array([0.0, 0.0, 1.0])
    across = np.cross(up, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(across))
    if sine < 1e-9:
        return np.eye(3) if up[2] > 0.0 else np.diag([1.0, -1.0, -1.0])
    return rotation_about_axis(across / sine, float(np.arctan2(sine, up[2])))


def _lowest(piece: Piece) -> float:
    """Return the height of the lowest point of a piece; of a mesh, that of its origin."""
    size, down = piece.size, piece.axes[2]
    if piece.kind == "box":
        reach = 0.5 * float(np.abs(down) @ np.array(size))
    elif piece.kind == "mesh":
        reach = 0.0
    else:
        flat = 0.5 * size[0] * (np.hypot(down[0], down[1]) if piece.kind == "cylinder" else 1.0)
        reach = float(flat + (0.5 * size[1] * abs(down[2]) if len(size) > 1 else 0.0))
    return float(piece.position[2]) - reach


FIELD_OF_VIEW = 30.0  # of view, vertical, deg
VIEW_AZIMUTH, VIEW_ELEVATION = 0.5, 0.35  # of the eye, rad: azimuth from the side of the arm towards its tip
PICTURE_MARGIN = 1.12  # of the distance, for a margin around the arm
DEFAULT_MESH_SIZE = 0.5  # assumed size of a mesh, m


class Viewpoint(NamedTuple):
    """Position of the eye, and direction of its view."""

    position: Array  # m, (3,)
    right: Array  # directions in the picture, of length 1, (3,)
    up: Array
    centre: Array  # of the visible pieces, m, (3,)
    radius: float  # of a ball around it, m


def viewpoint(pieces: Sequence[Piece], floor: float, aspect: float) -> Viewpoint:
    """Return the viewpoint from the side and from above that shows all pieces.

    Args:
        pieces: pieces in the room, from base to tip.
        floor: height below which nothing is of interest, m.
        aspect: width of the picture over its height.
    """
    centre, radius = _bounding_ball(pieces, floor)
    positions = np.array([piece.position[:2] for piece in pieces])
    _, _, directions = np.linalg.svd(positions - positions.mean(axis=0), full_matrices=True)
    main = directions[0] if directions[0] @ (positions[-1] - positions[0]) >= 0.0 else -directions[0]
    heading = float(np.arctan2(main[1], main[0])) - 0.5 * pi + VIEW_AZIMUTH
    back = np.array(
        [np.cos(heading) * np.cos(VIEW_ELEVATION), np.sin(heading) * np.cos(VIEW_ELEVATION), np.sin(VIEW_ELEVATION)]
    )
    right = np.array([-np.sin(heading), np.cos(heading), 0.0])
    half = np.radians(FIELD_OF_VIEW) / 2
    distance = PICTURE_MARGIN * radius / np.sin(min(half, atan(tan(half) * aspect)))
    return Viewpoint(centre + distance * back, right, np.cross(back, right), centre, radius)


def _bounding_ball(pieces: Sequence[Piece], floor: float) -> tuple[Array, float]:
    """Return centre and radius (m) of a ball around all pieces, above the floor."""
    reaches = np.array([0.5 * float(np.linalg.norm(piece.size or (DEFAULT_MESH_SIZE,))) for piece in pieces])
    places = np.array([piece.position for piece in pieces])
    low, high = (places - reaches[:, None]).min(axis=0), (places + reaches[:, None]).max(axis=0)
    low[2] = max(low[2], floor)
    centre = 0.5 * (low + high)
    return centre, float(np.max(np.linalg.norm(places - centre, axis=1) + reaches))
