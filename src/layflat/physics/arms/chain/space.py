"""Vectors, rotations and inertias in space.

| symbol | meaning | unit |
|---|---|---|
| m | mass | kg |
| h | first moment of mass about the origin | kg m |
| J | second moment, the inertia about the origin | kg m2 |
"""

from typing import NamedTuple

from layflat.jit import law


class Vector(NamedTuple):
    """Components along three axes."""

    x: float
    y: float
    z: float


class Axes(NamedTuple):
    """A rotation: unit vectors of a frame, as the frame around it has them."""

    x: Vector
    y: Vector
    z: Vector


class Symmetric(NamedTuple):
    """A symmetric matrix, such as an inertia, kg m2."""

    xx: float
    yy: float
    zz: float
    xy: float
    xz: float
    yz: float


class Mass(NamedTuple):
    """A rigid body about the origin of its frame."""

    m: float
    h: Vector
    J: Symmetric


@law
def plus(a, b):
    """Return a + b."""
    return Vector(a.x + b.x, a.y + b.y, a.z + b.z)


@law
def scaled(s, a):
    """Return a, s times as long."""
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
def outward(axes, a):
    """Return a vector, given in a frame with these axes, as the frame around has it."""
    return Vector(
        axes.x.x * a.x + axes.y.x * a.y + axes.z.x * a.z,
        axes.x.y * a.x + axes.y.y * a.y + axes.z.y * a.z,
        axes.x.z * a.x + axes.y.z * a.y + axes.z.z * a.z,
    )


@law
def transposed(axes):
    """Return the axes of the frame around, as a frame with these axes has them."""
    return Axes(
        Vector(axes.x.x, axes.y.x, axes.z.x), Vector(axes.x.y, axes.y.y, axes.z.y), Vector(axes.x.z, axes.y.z, axes.z.z)
    )


@law
def within(axes, other):
    """Return axes that are given in a frame with these axes, as the frame around has them."""
    return Axes(outward(axes, other.x), outward(axes, other.y), outward(axes, other.z))


@law
def turned(axes, sin, cos):
    """Return axes turned about their z by an angle with this sine and cosine."""
    x, y = axes.x, axes.y
    return Axes(plus(scaled(cos, x), scaled(sin, y)), plus(scaled(-sin, x), scaled(cos, y)), axes.z)


@law
def applied(J, a):
    """Return J a."""
    return Vector(
        J.xx * a.x + J.xy * a.y + J.xz * a.z, J.xy * a.x + J.yy * a.y + J.yz * a.z, J.xz * a.x + J.yz * a.y + J.zz * a.z
    )


@law
def _seen(J, axes):
    # R J R^T, where the columns x, y, z of R are the axes. As x x^T + y y^T + z z^T = 1, it is what z has for all
    # directions, and x u^T + u x^T + y v^T + v y^T besides: three quarters of the products.
    x, y, z = axes.x, axes.y, axes.z
    u = plus(plus(scaled(0.5 * (J.xx - J.zz), x), scaled(J.xy, y)), scaled(J.xz, z))
    v = plus(scaled(0.5 * (J.yy - J.zz), y), scaled(J.yz, z))
    return Symmetric(
        J.zz + 2.0 * (x.x * u.x + y.x * v.x),
        J.zz + 2.0 * (x.y * u.y + y.y * v.y),
        J.zz + 2.0 * (x.z * u.z + y.z * v.z),
        (x.x * u.y + x.y * u.x) + (y.x * v.y + y.y * v.x),
        (x.x * u.z + x.z * u.x) + (y.x * v.z + y.z * v.x),
        (x.y * u.z + x.z * u.y) + (y.y * v.z + y.z * v.y),
    )


@law
def _shifted(J, p, k):
    # J about a point from which the body's own origin is p away; k = h + m p / 2.
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
def seen_from(body, axes, p):
    """Return a body about another origin: its own frame has these axes there, and lies p away."""
    m, h = body.m, outward(axes, body.h)
    half = plus(h, scaled(0.5 * m, p))
    return Mass(m, plus(h, scaled(m, p)), _shifted(_seen(body.J, axes), p, half))


@law
def with_point(body, m, at):
    """Return a body with a point of mass m at a place."""
    x, y, z = at.x * at.x, at.y * at.y, at.z * at.z
    J = body.J
    return Mass(
        body.m + m,
        plus(body.h, scaled(m, at)),
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
def together(a, b):
    """Return two bodies as one."""
    A, B = a.J, b.J
    return Mass(
        a.m + b.m,
        plus(a.h, b.h),
        Symmetric(A.xx + B.xx, A.yy + B.yy, A.zz + B.zz, A.xy + B.xy, A.xz + B.xz, A.yz + B.yz),
    )
