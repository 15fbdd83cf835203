"""Geometry that descriptions, scene and perception share: rectangles on the table, quaternions (w first), a circle.

Lengths in m, angles in rad, counter-clockwise seen from above.
"""

from math import cos, sin

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array

Quaternion = tuple[float, float, float, float]


def rectangle_corners(centre: tuple[float, float], rotation: float, size: tuple[float, float]) -> Array:
    """Return the corners of a rotated rectangle, counter-clockwise from its (-x, -y) corner, (4, 2) m.

    Args:
        centre: m.
        rotation: rotation of its x axis, rad.
        size: along its x and y axes, m.
    """
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(size) / 2
    return to_parent_frame(centre, rotation, corners)


def to_parent_frame(centre: tuple[float, float], rotation: float, points: ArrayLike) -> Array:
    """Return points of a part's frame in the parent frame, (n, 2) m.

    Args:
        centre: centre of the part in the parent frame, m.
        rotation: rotation of the part in the parent frame, rad.
        points: points in the part's frame, (n, 2) m.
    """
    c, s = np.cos(rotation), np.sin(rotation)
    rotated_points: Array = np.asarray(points) @ np.array([[c, s], [-s, c]]) + np.array(centre)
    return rotated_points


def outlines_overlap(first: Array, second: Array) -> bool:
    """Return whether two convex outlines (n, 2), m, overlap (touching is none), by the separating axis theorem."""
    for outline in (first, second):
        sides = np.roll(outline, -1, axis=0) - outline
        for side in sides:
            across = np.array([-side[1], side[0]])
            first_range, second_range = first @ across, second @ across
            if first_range.max() <= second_range.min() or second_range.max() <= first_range.min():
                return False
    return True


def rotation_about_z(angle: float) -> Array:
    """Return the quaternion of a rotation about the vertical axis by an angle, rad."""
    return np.array([cos(angle / 2), 0.0, 0.0, sin(angle / 2)])


def quaternion_product(p: Array, q: Array) -> Array:
    """Return the product of two quaternions: the rotation q, then p."""
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def rotate_vector(q: Array, v: Array) -> Array:
    """Return a vector (3,) rotated by a unit quaternion."""
    return np.asarray(v + 2.0 * np.cross(q[1:], np.cross(q[1:], v) + q[0] * v))


def look_at_orientation(position: ArrayLike, target: ArrayLike, rotation: float) -> Quaternion:
    """Return the orientation of a camera aimed at a point, in MuJoCo's convention: view along -z, x right, y up.

    Its y axis is as near to vertical as possible, and to +y where it looks straight down, then rotated about the line
    of sight.

    Args:
        position: position of the camera, (3,) m.
        target: point at which it is aimed, (3,) m.
        rotation: about the line of sight, counter-clockwise seen from above, rad.
    """
    back = np.subtract(position, target)
    back = back / np.linalg.norm(back)
    up = np.array([0.0, 1.0, 0.0]) if abs(back[2]) > 0.999 else np.array([0.0, 0.0, 1.0])
    right = np.cross(up, back)
    right = right / np.linalg.norm(right)
    up = np.cross(back, right)
    x = cos(rotation) * right + sin(rotation) * up
    return _quaternion(np.stack([x, np.cross(back, x), back], axis=1))


def _quaternion(R: Array) -> Quaternion:
    """Return the quaternion of a rotation matrix, by the eigenvector of its symmetric form (Bar-Itzhack 2000)."""
    K = np.array(
        [
            [R[0, 0] - R[1, 1] - R[2, 2], R[1, 0] + R[0, 1], R[2, 0] + R[0, 2], R[2, 1] - R[1, 2]],
            [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], R[2, 1] + R[1, 2], R[0, 2] - R[2, 0]],
            [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
            [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]],
        ]
    )
    x, y, z, w = np.linalg.eigh(K)[1][:, -1]
    return float(w), float(x), float(y), float(z)


def unit_circle(count: int) -> Array:
    """Return equidistant points (count, 2) of the unit circle, the first at (1, 0)."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
