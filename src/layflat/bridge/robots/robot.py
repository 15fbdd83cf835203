"""A robot as files of robots describe it: bodies and joints, whatever the format."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.physics.arms.bodies import about

HINGE, FIXED, SLIDE = "hinge", "fixed", "prismatic"
STANDARD = (0.0, 0.0, -9.80665)  # gravity where a file tells none: z is up, m/s2


class Pose(NamedTuple):
    """Position and orientation of a frame in another one."""

    axes: Array  # columns: its axes, (3, 3)
    place: Array  # of its origin, m, (3,)

    def then(self, inner: Pose) -> Pose:
        """Return where a frame lies that lies somewhere in this one."""
        return Pose(self.axes @ inner.axes, self.place + self.axes @ inner.place)

    def back(self) -> Pose:
        """Return where the other frame lies in this one."""
        return Pose(self.axes.T, -self.axes.T @ self.place)


def at(place: Sequence[float] | Array) -> Pose:
    """Return a pose that is not turned."""
    return Pose(np.eye(3), np.array(place, float))


def unit_vector(way: Array) -> Array:
    """Return the direction (3,) of a vector that is not zero, however long."""
    scaled: Array = way / np.abs(way).max()
    return scaled / np.linalg.norm(scaled)


class Inertial(NamedTuple):
    """Mass of a body."""

    mass: float  # kg
    centre: Array  # in the body's frame, m, (3,)
    inertia: Array  # about the centre, along the axes of the body's frame, kg m2, (3, 3)

    def seen_from(self, pose: Pose) -> Inertial:
        """Return the same in the frame in which the body's frame lies so."""
        return Inertial(self.mass, pose.place + pose.axes @ self.centre, pose.axes @ self.inertia @ pose.axes.T)


@dataclass(frozen=True)
class Look:
    """Shape by which a body is drawn; sizes as in a description's shapes, m."""

    kind: str
    pose: Pose  # in the body's frame
    size: tuple[float, ...] = ()
    named: str = ""  # name of a mesh's file as it stands in the robot's, until `mesh_files` has looked for it
    file: Path | None = None  # of a mesh
    content: bytes = b""  # of a mesh that is in no file as it is drawn: a binary STL
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    body: str = ""  # that it belongs to


@dataclass
class Body:
    """A body, which a format may call a link."""

    name: str
    inertial: Inertial | None = None
    looks: list[Look] = field(default_factory=list)
    solid: bool = False  # whether it has any geometry, drawn or not


class Mimic(NamedTuple):
    """Coupling of a joint to another one: multiplier x its position + offset."""

    joint: str
    multiplier: float
    offset: float  # rad or m


@dataclass(frozen=True)
class Link:
    """Connection of a body to another one: a joint, or a fixed connection. Positions are in rad, or in m of slides."""

    name: str
    kind: str  # HINGE, FIXED, SLIDE, or another word for what it is instead
    parent: str
    child: str
    pose: Pose  # of the child's frame in the parent's, where the joint is at `zero`
    axis: Array | None = None  # of the joint, in the child's frame, of any length
    anchor: Array = field(default_factory=lambda: np.zeros(3))  # a point of that axis, in the child's frame, m
    limits: tuple[float, float] | None = None  # as the file has them, which may be none that a joint can have
    soft_limits: tuple[float, float] | None = None  # within which the joint works, where the file has such
    zero: float = 0.0  # position of the joint in the pose in which the file draws the robot
    armature: float = 0.0  # kg m2
    mimic: Mimic | None = None

    def displaced(self, way: float) -> Pose:
        """Return the pose of the child's frame in the parent's once a hinge or slide has moved from `zero`."""
        if way == 0.0 or self.axis is None or not self.axis.any() or self.kind not in {HINGE, SLIDE}:
            return self.pose
        axis = unit_vector(self.axis)
        if self.kind == SLIDE:
            return self.pose.then(at(way * axis))
        return self.pose.then(at(self.anchor)).then(Pose(about(axis, way), np.zeros(3))).then(at(-self.anchor))


@dataclass
class Robot:
    """All of a file."""

    file: Path
    name: str
    noun: str  # what the format calls a body
    base: str
    bodies: dict[str, Body]
    links: list[Link]
    frames: dict[str, tuple[str, Pose]]  # named places besides bodies: on which body, and where
    gravity: Array | None = None  # m/s2, in the frame of the base; None: not told
    loops: list[tuple[str, set[str]]] = field(default_factory=list)  # what closes loops, and the bodies it ties
    left_out: list[str] = field(default_factory=list)  # what it has beside, and an arm here has not
    notes: list[str] = field(default_factory=list)  # on numbers that could not be taken as they stand
    mesh_folder: str = ""  # in which, beside the file, meshes may be that are not where their names say

    def on(self, body: str) -> list[Link]:
        """Return what hangs on a body."""
        return [link for link in self.links if link.parent == body]

    def behind(self, body: str) -> Iterator[str]:
        """Yield a body and all that hang on it, however far."""
        yield body
        for link in self.on(body):
            yield from self.behind(link.child)

    def to(self, body: str) -> list[Link]:
        """Return the links from the base to a body."""
        over = {link.child: link for link in self.links}
        way: list[Link] = []
        while body in over:
            way.insert(0, over[body])
            body = over[body].parent
        return way
