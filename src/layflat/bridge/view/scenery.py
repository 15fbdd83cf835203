"""An arm to look at: all that is drawn of it, frame by frame, upright, with a floor below; and viewpoints."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import atan, pi, radians, tan
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.bridge.pieces import Piece, along, joint_pieces, link_pieces, rigid
from layflat.machine import Machine
from layflat.physics.arms.bodies import RigidArm, about

SQUARE = 0.1  # of the floor, m
POST = 0.6  # diameter of the post that an arm stands on, over that of the body of its first joint
ROOM = 0.02  # between a horizontal arm and the floor, m
FINE = radians(3.0)  # of arcs
TIP = 0.046  # diameter of the ball at the tip, m


@dataclass(frozen=True)
class Scenery:
    """Pieces that are drawn of an arm. Frames are those of the base (0), of the links, and of the tool (last)."""

    machine: Machine
    arm: RigidArm
    level: Array  # columns: axes of the base, as the room has them, in which gravity pulls against z, (3, 3)
    pieces: tuple[tuple[int, Piece], ...]  # with the frames that they are in
    floor: float  # its height, m

    def frames(self, angles: Sequence[float] | Array) -> list[tuple[Array, Array]]:
        """Return axes (3, 3) and origins (m, (3,)) of all frames at some angles (rad), as the room has them."""
        poses = [(np.eye(3), np.zeros(3)), *self.arm.poses(angles)]
        return [(self.level @ axes, self.level @ origin) for axes, origin in poses]

    def placed(self, angles: Sequence[float] | Array) -> list[Piece]:
        """Return all pieces as the room has them."""
        frames = self.frames(angles)
        return [placed(piece, *frames[frame]) for frame, piece in self.pieces]

    def tip(self, angles: Sequence[float] | Array) -> Array:
        """Return where the tip is in the frame of the base, m, (3,)."""
        return self.arm.poses(angles)[-1][1]


def scenery(machine: Machine, angles: Sequence[float]) -> Scenery:
    """Return what is drawn of a machine's arm, on a floor that suits some angles (rad).

    Raises:
        InputError: the arm is of a kind without bodies, or a mesh is not there.
    """
    arm, bodies = rigid(machine), joint_pieces(machine)
    pieces = [(i, piece) for i, own in enumerate(link_pieces(machine), 1) for piece in [*own, bodies[i - 1]]]
    pieces.append((len(arm.links) + 1, Piece("sphere", np.zeros(3), np.eye(3), (TIP,), "tip")))
    bare = Scenery(machine, arm, _level(arm.gravity), tuple(pieces), 0.0)
    first = placed(bodies[0], *bare.frames(angles)[1])
    low = min(_lowest(piece) for piece in bare.placed(angles))
    floor = 0.0 if low >= 0.0 else low - ROOM
    height = float(first.place[2]) - floor
    if height > ROOM:
        foot = first.place - np.array([0.0, 0.0, 0.5 * height])
        post = Piece("cylinder", bare.level.T @ foot, bare.level.T, (POST * bodies[0].size[0], height), "link")
        pieces = [(0, post), *pieces]
    return replace(bare, pieces=tuple(pieces), floor=floor)


def placed(piece: Piece, axes: Array, origin: Array) -> Piece:
    """Return a piece of a frame as the frame around it has it."""
    return replace(piece, place=origin + axes @ piece.place, axes=axes @ piece.axes)


def stroke_arcs(shown: Scenery, joint: int) -> tuple[Array, Array]:
    """Return segments (n, 2, 3), m, of the working stroke of a joint, and of what is left to its stops.

    They are in the frame before the joint, as its link sees it in mid-stroke; a dash at each end.
    """
    link = shown.arm.links[joint]
    end = shown.arm.links[joint + 1].place if joint + 1 < len(shown.arm.links) else shown.arm.tool
    across = end - link.axis * (link.axis @ end)
    length = float(np.linalg.norm(across))
    way = across / length if length > SQUARE else along(link.axis)[:, 0]
    stops = list(shown.machine.joints.values())[joint].stops
    radius = max(0.4 * length, SQUARE)
    works, most = 0.5 * stops.working_stroke, 0.5 * stops.mechanical_stroke
    inner = _arc(link.axis, radius * way, -works, works)
    outer = [*_arc(link.axis, radius * way, -most, -works), *_arc(link.axis, radius * way, works, most)]
    dashes = [_dash(link.axis, radius * way, angle) for angle in (-most, most)]
    return _as_before(link.axes, link.place, inner), _as_before(link.axes, link.place, [*outer, *dashes])


def _as_before(axes: Array, place: Array, segments: list[Array]) -> Array:
    found: Array = np.array(segments).reshape(-1, 2, 3) @ axes.T + place
    return found


def _arc(axis: Array, arm: Array, begin: float, end: float) -> list[Array]:
    angles = np.linspace(begin, end, max(int(abs(end - begin) / FINE) + 1, 2))
    points = [about(axis, angle) @ arm for angle in angles]
    return [np.array(pair) for pair in pairwise(points)]


def _dash(axis: Array, arm: Array, angle: float) -> Array:
    out = about(axis, angle) @ arm
    return np.array([0.9 * out, 1.1 * out])


def _level(gravity: Array) -> Array:
    """Return the axes in which gravity pulls against z; without gravity those that are there."""
    strength = float(np.linalg.norm(gravity))
    up = -gravity / strength if strength > 0.0 else np.array([0.0, 0.0, 1.0])
    across = np.cross(up, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(across))
    if sine < 1e-9:
        return np.eye(3) if up[2] > 0.0 else np.diag([1.0, -1.0, -1.0])
    return about(across / sine, float(np.arctan2(sine, up[2])))


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
    return float(piece.place[2]) - reach


FIELD = 30.0  # of view, vertical, deg
ASIDE, ABOVE = 0.5, 0.35  # rad: where one stands, from the side of the arm towards its tip, and over it
MARGIN = 1.12  # of a picture around the arm
UNKNOWN = 0.5  # size of a mesh, of which only the place counts, m


class Viewpoint(NamedTuple):
    """Place of the eye, and direction of its view."""

    place: Array  # m, (3,)
    right: Array  # directions in the picture, of length 1, (3,)
    up: Array
    centre: Array  # of what is seen, m, (3,)
    radius: float  # of a ball around it, m


def viewpoint(pieces: Sequence[Piece], floor: float, aspect: float) -> Viewpoint:
    """Return from where all pieces are seen, from aside and from above.

    Args:
        pieces: in the room, from base to tip.
        floor: height below which nothing is of interest, m.
        aspect: width of the picture over its height.
    """
    centre, radius = _ball(pieces, floor)
    spread = np.array([piece.place[:2] for piece in pieces])
    _, _, ways = np.linalg.svd(spread - spread.mean(axis=0), full_matrices=True)
    lead = ways[0] if ways[0] @ (spread[-1] - spread[0]) >= 0.0 else -ways[0]
    heading = float(np.arctan2(lead[1], lead[0])) - 0.5 * pi + ASIDE
    back = np.array([np.cos(heading) * np.cos(ABOVE), np.sin(heading) * np.cos(ABOVE), np.sin(ABOVE)])
    right = np.array([-np.sin(heading), np.cos(heading), 0.0])
    half = np.radians(FIELD) / 2
    distance = MARGIN * radius / np.sin(min(half, atan(tan(half) * aspect)))
    return Viewpoint(centre + distance * back, right, np.cross(back, right), centre, radius)


def _ball(pieces: Sequence[Piece], floor: float) -> tuple[Array, float]:
    """Return middle and radius of a ball around all pieces, as far as they are above the floor."""
    reaches = np.array([0.5 * float(np.linalg.norm(piece.size or (UNKNOWN,))) for piece in pieces])
    places = np.array([piece.place for piece in pieces])
    low, high = (places - reaches[:, None]).min(axis=0), (places + reaches[:, None]).max(axis=0)
    low[2] = max(low[2], floor)
    centre = 0.5 * (low + high)
    return centre, float(np.max(np.linalg.norm(places - centre, axis=1) + reaches))
