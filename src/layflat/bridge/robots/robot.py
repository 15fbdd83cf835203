"""Robot as URDF and MJCF describe it: bodies and joints, independent of the format."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.physics.arms.bodies import rotation_about_axis

HINGE_JOINT, FIXED_JOINT, SLIDE_JOINT = "hinge", "fixed", "prismatic"
DEFAULT_GRAVITY = (0.0, 0.0, -9.80665)  # of files without gravity: z is up, m/s2


class Pose(NamedTuple):
    """Position and orientation of a frame in another one."""

    axes: Array  # columns: its axes, (3, 3)
    position: Array  # of its origin, m, (3,)

    def then(self, inner: Pose) -> Pose:
        """Return the pose of a frame, given in this frame, in the parent of this one."""
        return Pose(self.axes @ inner.axes, self.position + self.axes @ inner.position)

    def back(self) -> Pose:
        """Return the inverse: the pose of the parent frame in this one."""
        return Pose(self.axes.T, -self.axes.T @ self.position)


def translation_pose(place: Sequence[float] | Array) -> Pose:
    """Return a pose without rotation."""
    return Pose(np.eye(3), np.array(place, float))


def unit_vector(vector: Array) -> Array:
    """Return the unit vector (3,) of a vector that is not zero, without overflow."""
    scaled: Array = vector / np.abs(vector).max()
    return scaled / np.linalg.norm(scaled)


class Inertial(NamedTuple):
    """Mass, centre and inertia of a body."""

    mass: float  # kg
    centre: Array  # in the body's frame, m, (3,)
    inertia: Array  # about the centre, along the axes of the body's frame, kg m2, (3, 3)

    def in_parent_frame(self, pose: Pose) -> Inertial:
        """Return the same in the parent frame, in which the body's frame has this pose."""
        return Inertial(self.mass, pose.position + pose.axes @ self.centre, pose.axes @ self.inertia @ pose.axes.T)


@dataclass(frozen=True)
class VisualShape:
    """Shape by which a body is drawn; sizes as in a description's shapes, m."""

    kind: str
    pose: Pose  # in the body's frame
    size: tuple[float, ...] = ()
    named: str = ""  # name of a mesh's file as written, until `mesh_files` has searched it
    file: Path | None = None  # of a mesh
    content: bytes = b""  # of a mesh without such a file: a binary STL
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    body: str = ""  # that it belongs to


@dataclass
class RobotBody:
    """Body of a robot, which URDF calls a link."""

    name: str
    inertial: Inertial | None = None
    looks: list[VisualShape] = field(default_factory=list)
    solid: bool = False  # whether it has any geometry, drawn or not


class Mimic(NamedTuple):
    """Coupling of a joint to another one: multiplier x its position + offset."""

    joint: str
    multiplier: float
    offset: float  # rad or m


@dataclass(frozen=True)
class RobotLink:
    """Connection of two bodies: a joint, or a fixed connection. Positions are in rad, or in m of slides."""

    name: str
    kind: str  # HINGE_JOINT, FIXED_JOINT, SLIDE_JOINT, or the format's word for another kind
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

    def displaced(self, displacement: float) -> Pose:
        """Return the pose of the child's frame in the parent's after a displacement from `zero`, rad or m.

        It is `pose` for joints without axis, and of other kinds than hinge and slide.
        """
        if (
            displacement == 0.0
            or self.axis is None
            or not self.axis.any()
            or self.kind not in {HINGE_JOINT, SLIDE_JOINT}
        ):
            return self.pose
        axis = unit_vector(self.axis)
        if self.kind == SLIDE_JOINT:
            return self.pose.then(translation_pose(displacement * axis))
        return (
            self.pose.then(translation_pose(self.anchor))
            .then(Pose(rotation_about_axis(axis, displacement), np.zeros(3)))
            .then(translation_pose(-self.anchor))
        )


@dataclass
class Robot:
    """Robot of a file."""

    file: Path
    name: str
    noun: str  # word of the format for a body
    base: str
    bodies: dict[str, RobotBody]
    links: list[RobotLink]
    frames: dict[str, tuple[str, Pose]]  # further named frames: body, and pose on it
    gravity: Array | None = None  # m/s2, in the frame of the base; None: not in the file
    loops: list[tuple[str, set[str]]] = field(
        default_factory=list
    )  # constraints that close loops, and the bodies they connect
    omitted: list[str] = field(default_factory=list)  # elements of the file that an import omits
    notes: list[str] = field(default_factory=list)  # on numbers that were changed
    mesh_folder: str = ""  # further folder of meshes, relative to the file

    def links_on(self, body: str) -> list[RobotLink]:
        """Return the links whose parent is a body."""
        return [link for link in self.links if link.parent == body]

    def subtree(self, body: str) -> Iterator[str]:
        """Yield a body and all its descendants."""
        yield body
        for link in self.links_on(body):
            yield from self.subtree(link.child)

    def links_to(self, body: str) -> list[RobotLink]:
        """Return the links from the base to a body, in this order."""
        by_child = {link.child: link for link in self.links}
        links: list[RobotLink] = []
        while body in by_child:
            links.insert(0, by_child[body])
            body = by_child[body].parent
        return links
