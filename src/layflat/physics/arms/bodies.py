"""An arm as rigid bodies, each in its own frame: for other engines and for drawing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from layflat.lazy import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.arrays import Array


@dataclass(frozen=True)
class RigidLink:
    """A link and all that moves rigidly with it, in the frame that its joint rotates."""

    place: Array  # position of the joint and of the frame's origin, in the frame of the link before, m, (3,)
    axes: Array  # columns: the frame's axes in mid-stroke, as the frame of the link before has them, (3, 3)
    axis: Array  # direction of the joint in the frame, of length 1, (3,)
    mass: float  # kg
    centre: Array  # of mass, in the frame, m, (3,)
    inertia: Array  # about the centre of mass, along the frame's axes, kg m2, (3, 3)
    armature: float = 0.0  # inertia that rotates with the joint's velocity alone (MuJoCo's armature), kg m2
    shapes: tuple[Any, ...] = ()  # shapes that it is drawn by (see `LinkShape` of chains)


@dataclass(frozen=True)
class RigidArm:
    """An arm from base to tip, without payload."""

    links: tuple[RigidLink, ...]
    tool: Array  # of payload and tip, in the frame of the last link, m, (3,)
    tool_axes: Array  # columns: axes of the tool's frame, as the frame of the last link has them, (3, 3)
    gravity: Array  # in the frame of the base, m/s2, (3,)

    def poses(self, angles: Sequence[float] | Array) -> list[tuple[Array, Array]]:
        """Return axes (3, 3) and origin (m, (3,)) of the frames of all links and of the tool, in that of the base.

        Angles of the joints are in rad, from mid-stroke.
        """
        axes, origin, frames = np.eye(3), np.zeros(3), []
        for link, angle in zip(self.links, angles, strict=True):
            origin = origin + axes @ link.place
            axes = axes @ link.axes @ rotation_about_axis(link.axis, angle)
            frames.append((axes, origin))
        return [*frames, (axes @ self.tool_axes, origin + axes @ self.tool)]


def rotation_about_axis(axis: Array, angle: float) -> Array:
    """Return the rotation matrix (3, 3) about an axis of length 1 by an angle, rad (Rodrigues' formula)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Array = np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew
    return rotation


def rotation_from_angles(turn: Sequence[float]) -> Array:
    """Return the rotation matrix of angles (rad) about x, then y, then z of the parent; its columns are the axes."""
    x, y, z = (rotation_about_axis(axis, angle) for axis, angle in zip(np.eye(3), turn, strict=True))
    return z @ y @ x


def angles_from_rotation(axes: Array) -> tuple[float, float, float]:
    """Return the angles (rad) about x, y and z of the parent frame: the inverse of `rotation_from_angles`."""
    b = np.arctan2(-axes[2, 0], np.hypot(axes[0, 0], axes[1, 0]))
    c = np.arctan2(axes[1, 0], axes[0, 0])
    # Rotation without that about z: where b is a quarter turn (gimbal lock), c is arbitrary, and a follows it.
    without_z = rotation_about_axis(np.array([0.0, 0.0, 1.0]), -c) @ axes
    return float(np.arctan2(-without_z[1, 2], without_z[1, 1])), float(b), float(c)


def inertia_matrix(inertia: Sequence[float]) -> Array:
    """Return the inertia matrix (3, 3) of the moments xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def lump_bodies(bodies: Sequence[tuple[float, Array, Array]]) -> tuple[float, Array, Array]:
    """Return the mass (kg), centre (m, (3,)) and central inertia (kg m2, (3, 3)) of bodies that move as one.

    Args: such triples, all in one frame.
    """
    mass = sum(m for m, _, _ in bodies)
    centre = sum((m * at for m, at, _ in bodies), np.zeros(3)) / mass if mass > 0.0 else bodies[0][1]
    inertia = np.zeros((3, 3))
    for m, at, central in bodies:
        d = at - centre
        inertia = inertia + central + m * (d @ d * np.eye(3) - np.outer(d, d))
    return float(mass), centre, inertia


def point_mass_body(mass: float, at: Sequence[float]) -> tuple[float, Array, Array]:
    """Return a point mass (kg) at a position (m) as a body of `lump_bodies`."""
    return mass, np.array(at, float), np.zeros((3, 3))
