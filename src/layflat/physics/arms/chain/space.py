"""Vectors, rotations and inertias in space.

| symbol | meaning | unit |
|---|---|---|
| m | mass | kg |
| h | first moment of mass about the origin | kg m |
| J | second moment, the inertia about the origin | kg m2 |
| a, b, p | vectors (`Vector`); p is a position | m |

`axes` are an `Axes`, J is a `Symmetric`, a body is a `RigidBody`.
"""

from typing import NamedTuple

from layflat.jit import law


class Vector(NamedTuple):
    """Vector by its components along three axes."""

    x: float  # in the unit of the vector
    y: float  # likewise
    z: float  # likewise


class Axes(NamedTuple):
    """Axes of a frame: its unit vectors in the parent frame (the columns of its rotation matrix)."""

    x: Vector
    y: Vector
    z: Vector


class Symmetric(NamedTuple):
    """Items of a symmetric matrix, such as an inertia, kg m2, whose item xy is minus the product of inertia."""

    xx: float  # kg m2
    yy: float  # kg m2
    zz: float  # kg m2
    xy: float  # kg m2
    xz: float  # kg m2
    yz: float  # kg m2


class RigidBody(NamedTuple):
    """Mass, first moment and inertia of a rigid body about the origin of its frame."""

    m: float  # mass, kg
    h: Vector  # first moment, kg m
    J: Symmetric  # inertia, kg m2


@law
def add_vectors(a, b):
    """Return a + b."""
    return Vector(a.x + b.x, a.y + b.y, a.z + b.z)


@law
def scale_vector(s, a):
    """Return s a."""
    return Vector(s * a.x, s * a.y, s * a.z)


@law
def dot(a, b):
    """Return the scalar product."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@law
def cross(a, b):
    """Return the vector product a x b."""
    return Vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@law
def to_parent_frame(axes, a):
    """Return a vector of a frame with these axes in the coordinates of the parent frame."""
    return Vector(
        axes.x.x * a.x + axes.y.x * a.y + axes.z.x * a.z,
        axes.x.y * a.x + axes.y.y * a.y + axes.z.y * a.z,
        axes.x.z * a.x + axes.y.z * a.y + axes.z.z * a.z,
    )


@law
def transpose_axes(axes):
    """Return the axes of the parent frame in a frame with these axes: the inverse rotation."""
    return Axes(
        Vector(axes.x.x, axes.y.x, axes.z.x), Vector(axes.x.y, axes.y.y, axes.z.y), Vector(axes.x.z, axes.y.z, axes.z.z)
    )


@law
def compose_axes(axes, other):
    """Return axes of a frame inside a frame with these axes, in the parent frame."""
    return Axes(to_parent_frame(axes, other.x), to_parent_frame(axes, other.y), to_parent_frame(axes, other.z))


@law
def turn_about_z(axes, sin, cos):
    """Return axes rotated about their z by an angle with this sine and cosine."""
    x, y = axes.x, axes.y
    return Axes(
        add_vectors(scale_vector(cos, x), scale_vector(sin, y)),
        add_vectors(scale_vector(-sin, x), scale_vector(cos, y)),
        axes.z,
    )


@law
def apply_inertia(J, a):
    """Return the product J a, a `Vector`."""
    return Vector(
        J.xx * a.x + J.xy * a.y + J.xz * a.z, J.xy * a.x + J.yy * a.y + J.yz * a.z, J.xz * a.x + J.yz * a.y + J.zz * a.z
    )


@law
def _rotate_inertia(J, axes):
    """Return R J R^T, kg m2, where the columns x, y, z of the rotation R are the axes.

    As x x^T + y y^T + z z^T = 1, it is J.zz times the identity, plus x u^T + u x^T + y v^T + v y^T: three quarters of
    the products.
    """
    x, y, z = axes.x, axes.y, axes.z
    u = add_vectors(add_vectors(scale_vector(0.5 * (J.xx - J.zz), x), scale_vector(J.xy, y)), scale_vector(J.xz, z))
    v = add_vectors(scale_vector(0.5 * (J.yy - J.zz), y), scale_vector(J.yz, z))
    return Symmetric(
        J.zz + 2.0 * (x.x * u.x + y.x * v.x),
        J.zz + 2.0 * (x.y * u.y + y.y * v.y),
        J.zz + 2.0 * (x.z * u.z + y.z * v.z),
        (x.x * u.y + x.y * u.x) + (y.x * v.y + y.y * v.x),
        (x.x * u.z + x.z * u.x) + (y.x * v.z + y.z * v.x),
        (x.y * u.z + x.z * u.y) + (y.y * v.z + y.z * v.y),
    )


@law
def _shift_inertia(J, p, k):
    """Return the inertia J (kg m2) about a point from which the body's origin is p away, m; k = h + m p / 2."""
    px, py, pz = p.x, p.y, p.z
    x, y, z = px * k.x, py * k.y, pz * k.z
    return Symmetric(
        J.xx + 2.0 * (y + z),
        J.yy + 2.0 * (x + z),
        J.zz + 2.0 * (x + y),
        J.xy - px * k.y - py * k.x,
        J.xz - px * k.z - pz * k.x,
        J.yz - py * k.z - pz * k.y,
    )


@law
def transform_body(body, axes, p):
    """Return a body in another frame, in which its own frame has these axes and the origin p."""
    m, h = body.m, to_parent_frame(axes, body.h)
    half = add_vectors(h, scale_vector(0.5 * m, p))
    return RigidBody(m, add_vectors(h, scale_vector(m, p)), _shift_inertia(_rotate_inertia(body.J, axes), p, half))


@law
def add_point_mass(body, m, at):
    """Return a body with a point mass m added at a position."""
    x, y, z = at.x * at.x, at.y * at.y, at.z * at.z
    J = body.J
    return RigidBody(
        body.m + m,
        add_vectors(body.h, scale_vector(m, at)),
        Symmetric(
            J.xx + m * (y + z),
            J.yy + m * (x + z),
            J.zz + m * (x + y),
            J.xy - m * at.x * at.y,
            J.xz - m * at.x * at.z,
            J.yz - m * at.y * at.z,
        ),
    )


@law
def merge_bodies(a, b):
    """Return two bodies of one frame merged into one."""
    A, B = a.J, b.J
    return RigidBody(
        a.m + b.m,
        add_vectors(a.h, b.h),
        Symmetric(A.xx + B.xx, A.yy + B.yy, A.zz + B.zz, A.xy + B.xy, A.xz + B.xz, A.yz + B.yz),
    )
