"""An arm as rigid bodies in frames of their own, as other engines and pictures want it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array


@dataclass(frozen=True)
class RigidLink:
    """A link with all that moves with it as one, in the frame that its joint turns."""

    place: Array  # of the joint, and of the frame's origin, in the frame of the link before, m, (3,)
    axes: Array  # columns: the frame's axes in mid-stroke, as the frame of the link before has them, (3, 3)
    axis: Array  # direction of the joint in the frame, of length 1, (3,)
    mass: float  # kg
    centre: Array  # of mass, in the frame, m, (3,)
    inertia: Array  # about the centre of mass, along the frame's axes, kg m2, (3, 3)
    armature: float = 0.0  # of what turns with the joint's speed alone, kg m2
    shapes: tuple[Any, ...] = ()  # how it is described to look (see `Shape` of chains)


@dataclass(frozen=True)
class RigidArm:
    """An arm from base to tip, without payload."""

    links: tuple[RigidLink, ...]
    tool: Array  # of payload and tip, in the frame of the last link, m, (3,)
    tool_axes: Array  # columns: axes of the tool's frame, as the frame of the last link has them, (3, 3)
    gravity: Array  # in the frame of the base, m/s2, (3,)

    def poses(self, angles: Sequence[float] | Array) -> list[tuple[Array, Array]]:
        """Return axes (3, 3) and origin (m, (3,)) of the frames of all links and of the tool, as the base has them."""
        axes, origin, found = np.eye(3), np.zeros(3), []
        for link, angle in zip(self.links, angles, strict=True):
            origin = origin + axes @ link.place
            axes = axes @ link.axes @ about(link.axis, angle)
            found.append((axes, origin))
        return [*found, (axes @ self.tool_axes, origin + axes @ self.tool)]


def about(axis: Array, angle: float) -> Array:
    """Return the rotation (3, 3) about an axis of length 1 by an angle, rad."""
    x, y, z = axis
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: Array = np.eye(3) + np.sin(angle) * across + (1.0 - np.cos(angle)) * across @ across
    return turned


def turned_by(turn: Sequence[float]) -> Array:
    """Return the axes (3, 3) of a frame turned about x, then y, then z of the frame around it, by angles, rad."""
    x, y, z = (about(axis, angle) for axis, angle in zip(np.eye(3), turn, strict=True))
    return z @ y @ x


def turn_of(axes: Array) -> tuple[float, float, float]:
    """Return the angles (rad) by which `turned_by` gives these axes (3, 3), which it does however they lie."""
    b = np.arctan2(-axes[2, 0], np.hypot(axes[0, 0], axes[1, 0]))
    c = np.arctan2(axes[1, 0], axes[0, 0])
    # What is left without the turn about z: where y is a quarter turn, c is anything, and this follows it.
    left = about(np.array([0.0, 0.0, 1.0]), -c) @ axes
    return float(np.arctan2(-left[1, 2], left[1, 1])), float(b), float(c)


def moments(inertia: Sequence[float]) -> Array:
    """Return the matrix (3, 3) of the moments xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def lumped(bodies: Sequence[tuple[float, Array, Array]]) -> tuple[float, Array, Array]:
    """Return bodies in one frame as one: each, and what is returned, is mass, centre, and inertia about the centre."""
    mass = sum(m for m, _, _ in bodies)
    centre = sum((m * at for m, at, _ in bodies), np.zeros(3)) / mass if mass > 0.0 else bodies[0][1]
    inertia = np.zeros((3, 3))
    for m, at, own in bodies:
        d = at - centre
        inertia = inertia + own + m * (d @ d * np.eye(3) - np.outer(d, d))
    return float(mass), centre, inertia


def point(mass: float, at: Sequence[float]) -> tuple[float, Array, Array]:
    """Return a point of mass as a body of `lumped`."""
    return mass, np.array(at, float), np.zeros((3, 3))
