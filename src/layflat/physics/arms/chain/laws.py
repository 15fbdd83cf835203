"""Rigid arms in space: serial chains of links, of any number of joints.

Everything is seen from the base. A motion is the velocity of rotation and that of the point of the body that passes the
base's origin; a force is a moment about that origin and a force. Bodies that move as one are added up from the tip.

| symbol | meaning | unit |
|---|---|---|
| z | axis of a joint | 1 |
| s | velocity of the origin with unit velocity of a joint: p x z, where p is a point of its axis | m |
| w, u | velocity of rotation, and of the origin | rad/s, m/s |
| a, b | accelerations: of rotation, and of the origin | rad/s2, m/s2 |
| W | matrix by which places become accelerations around the origin: W r = a x r + w x (w x r) | 1/s2 |
| n, f | moment about the origin, and force | N m, N |
| L, P | angular momentum about the origin, and momentum | N m s, N s |

Source: composite bodies and recursive Newton-Euler in spatial coordinates (featherstone2008, chapters 5 and 6).
"""

from typing import NamedTuple

from layflat.jit import composition, law
from layflat.lanes import abreast, apart, each, gather, in_lanes, packed, slots, sums_from, sums_up_to, unpacked
from layflat.physics.algebra import minus
from layflat.physics.arms.chain.space import (
    Axes,
    Mass,
    Vector,
    applied,
    cross,
    dot,
    outward,
    plus,
    scaled,
    seen_from,
    with_point,
)
from layflat.physics.trig import sincos, within_half_a_turn

THREE = (0.0, 0.0, 0.0)  # as many as there are components


class Link(NamedTuple):
    """A link in a frame of its own: its joint turns about z, and x is at right angles to the axis of the next joint."""

    sin_tilt: float  # of z, about x of the frame before
    cos_tilt: float
    sin_turn: float  # of x at mid-stroke, about z, from x of the frame before
    cos_turn: float
    place: Vector  # of its origin in the frame before, m
    body: Mass


class Chain(NamedTuple):
    """Parameters of an arm, without payload."""

    base: Axes  # the frame before the first link, which stands at the base's origin
    links: tuple[Link, ...]  # from base to tip
    armatures: tuple[float, ...]  # inertia of what turns with the joints' speeds alone, as the mass matrix, kg m2
    tool: Vector  # where the payload is in the frame of the last link, m
    gravity: Vector  # m/s2


class Frame(NamedTuple):
    """A frame as the base has it."""

    axes: Axes
    origin: Vector  # m


class _Screw(NamedTuple):
    z: Vector
    s: Vector


class _Twist(NamedTuple):
    w: Vector
    u: Vector


class _Wrench(NamedTuple):
    n: Vector
    f: Vector


class _Row(NamedTuple):
    # One component of the vectors of a frame.
    x: float
    y: float
    z: float
    origin: float


@law
def _offset(link, sin, cos):
    return sin * link.cos_turn + cos * link.sin_turn, cos * link.cos_turn - sin * link.sin_turn


@law
def _rows(base, zero):
    # The base's frame, component by component.
    x, y, z = base.x, base.y, base.z
    return (
        _Row(x.x + zero, y.x + zero, z.x + zero, zero),
        _Row(x.y + zero, y.y + zero, z.y + zero, zero),
        _Row(x.z + zero, y.z + zero, z.z + zero, zero),
    )


@law
def _beyond(row, link, sin, cos):
    x, y, z, at = row.x, row.y, row.z, link.place
    level = link.cos_tilt * y + link.sin_tilt * z
    origin = (at.x * x + at.y * y) + (at.z * z + row.origin)
    return _Row(cos * x + sin * level, cos * level - sin * x, link.cos_tilt * z - link.sin_tilt * y, origin)


@law
def _frame(x, y, z):
    return Frame(
        Axes(Vector(x.x, y.x, z.x), Vector(x.y, y.y, z.y), Vector(x.z, y.z, z.z)), Vector(x.origin, y.origin, z.origin)
    )


@composition
def _framed(rows):
    x, y, z = unpacked(rows, THREE)
    return _frame(x, y, z)


@composition
def frames(arm, q):
    """Return the frames of all links at angles (rad), a tuple."""
    sines, cosines = sincos(within_half_a_turn(abreast(q)))
    sines, cosines = _offset(abreast(arm.links), sines, cosines)
    sin, cos, links = slots(apart(sines, q)), slots(apart(cosines, q)), slots(arm.links)
    found = slots(q, packed(_rows(arm.base, in_lanes(0.0, sin[0]))))
    for i in range(len(q)):
        found[i] = each(_beyond, found[max(i - 1, 0)], links[i], sin[i], cos[i])
    return each(_framed, gather(q, found))


@law
def _screw(frame):
    return _Screw(frame.axes.z, cross(frame.origin, frame.axes.z))


@law
def _loaded(link, payload, tool):
    turns = link.sin_tilt, link.cos_tilt, link.sin_turn, link.cos_turn
    return Link(*turns, link.place, with_point(link.body, payload, tool))


@composition
def _carrying(arm, payload):
    # In the last link's own frame the payload is the same at all angles: it is found once for many steps.
    links = slots(arm.links)
    last = len(arm.links) - 1
    links[last] = _loaded(links[last], payload, arm.tool)
    return abreast(gather(arm.links, links))


@law
def _body(link, frame):
    return seen_from(link.body, frame.axes, frame.origin)


@law
def _pushed(body, screw):
    # Momentum of a body with unit velocity of a joint.
    z, s = screw.z, screw.s
    return _Wrench(plus(applied(body.J, z), cross(body.h, s)), plus(scaled(body.m, s), cross(z, body.h)))


@law
def _on(screw, wrench):
    # What a moment and a force do about a joint.
    return dot(screw.z, wrench.n) + dot(screw.s, wrench.f)


@law
def _turning(screw, v):
    return _Twist(scaled(v, screw.z), scaled(v, screw.s))


@law
def _bent(twist, screw, v):
    # What a joint adds to the accelerations: its axis is carried along by the links before it. (Its own turn adds
    # nothing, so that the motion after it may stand for that before.)
    z, s = scaled(v, screw.z), scaled(v, screw.s)
    return _Twist(cross(twist.w, z), plus(cross(twist.w, s), cross(twist.u, z)))


@law
def _needed(body, twist, rate):
    # Moment and force that a body needs for its accelerations, of which c is that of its point at the origin:
    # f = m c + W h, and n is h x c and what J makes of W.
    w, a, h, J = twist.w, rate.w, body.h, body.J
    c = plus(rate.u, cross(w, twist.u))
    xx, yy, zz, xy, xz, yz = w.x * w.x, w.y * w.y, w.z * w.z, w.x * w.y, w.x * w.z, w.y * w.z
    W_xy, W_yx, W_xz, W_zx, W_yz, W_zy = xy - a.z, xy + a.z, xz + a.y, xz - a.y, yz - a.x, yz + a.x
    f = Vector(
        W_xy * h.y + W_xz * h.z - (yy + zz) * h.x,
        W_yx * h.x + W_yz * h.z - (xx + zz) * h.y,
        W_zx * h.x + W_zy * h.y - (xx + yy) * h.z,
    )
    n = Vector(
        J.xx * a.x + (J.zz - J.yy) * yz + (J.xz * W_yx - J.xy * W_zx) + J.yz * (yy - zz),
        J.yy * a.y + (J.xx - J.zz) * xz + (J.xy * W_zy - J.yz * W_xy) + J.xz * (zz - xx),
        J.zz * a.z + (J.yy - J.xx) * xy + (J.yz * W_xz - J.xz * W_yz) + J.xy * (xx - yy),
    )
    return _Wrench(plus(n, cross(h, c)), plus(scaled(body.m, c), f))


@law
def _pull(pushed, gravity):
    # Of the weight of a body about a joint: what it does is in proportion to the momentum.
    return dot(pushed.f, gravity)


@composition
def _for_all(item, like):
    return abreast(gather(like, slots(like, item)))


@law
def _held(tool, frame):
    return plus(frame.origin, outward(frame.axes, tool))


@composition
def dynamics(arm, payload, q, v):
    """Return mass matrix, torques of velocities and of gravity (see `ArmLaws`)."""
    # All links side by side: what each of them has is found at once.
    placed, n = abreast(frames(arm, q)), len(q)
    own = _body(_carrying(arm, payload), placed)
    screw, speed = _screw(placed), abreast(v)
    twist = sums_up_to(_turning(screw, speed), q)
    rate = sums_up_to(_bent(twist, screw, speed), q)
    carried, needed = sums_from(own, q), sums_from(_needed(own, twist, rate), q)
    pushed = _pushed(carried, screw)
    moving, pulled = minus(_on(screw, needed)), _pull(pushed, _for_all(arm.gravity, q))
    pushes = slots(apart(pushed, q))
    M = slots(arm.armatures)
    for j in range(n):
        column = slots(apart(_on(screw, _for_all(pushes[j], q)), q))
        at = j  # in the triangle's first row; in each further row one place less to the right
        for i in range(j + 1):
            M[at] = M[at] + column[i]
            at += n - 1 - i
    return gather(arm.armatures, M), apart(moving, q), apart(pulled, q)


@law
def _origin(frame):
    return frame.origin


@composition
def points(arm, q):
    """Return where the joints are, and the tool (see `ArmLaws`)."""
    placed = frames(arm, q)
    hand = placed[len(q) - 1]
    return *each(_origin, placed), _held(arm.tool, hand)


@law
def _axis(frame):
    return frame.axes.z


@composition
def turning(arm, q):
    """Return the directions of the joints' axes (see `ArmLaws`)."""
    return each(_axis, frames(arm, q))
