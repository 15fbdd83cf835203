"""Rigid arms in space: serial chains of links, of any number of joints.

All quantities are in the frame of the base. A motion (twist) is the angular velocity and the velocity of the body's
point at the base's origin; a force (wrench) is a moment about that origin and a force. Composite bodies are summed from
the tip.

| symbol | meaning | unit |
|---|---|---|
| z | axis of a joint | 1 |
| s | velocity of the origin with unit velocity of a joint: p x z, where p is a point of its axis | m |
| w, u | angular velocity, and velocity of the origin | rad/s, m/s |
| a, b | angular acceleration, and acceleration of the origin | rad/s2, m/s2 |
| W | matrix from positions to accelerations about the origin: W r = a x r + w x (w x r) | 1/s2 |
| n, f | moment about the origin, and force | N m, N |
| L, P | angular momentum about the origin, and momentum | N m s, N s |

Source: composite bodies and recursive Newton-Euler in spatial coordinates (featherstone2008, chapters 5 and 6).
"""

from typing import NamedTuple

from layflat.jit import composition, law
from layflat.lanes import abreast, apart, each, gather, in_lanes, packed, slots, sums_from, sums_up_to, unpacked
from layflat.physics.algebra import negate
from layflat.physics.arms.chain.space import (
    Axes,
    RigidBody,
    Vector,
    add_point_mass,
    add_vectors,
    apply_inertia,
    cross,
    dot,
    scale_vector,
    to_parent_frame,
    transform_body,
)
from layflat.physics.trig import sincos, wrap_angle

COMPONENTS_LIKE = (0.0, 0.0, 0.0)  # a tuple with an item a component (x, y, z)


class ChainLink(NamedTuple):
    """A link in its own frame: its joint turns about z, and x is at right angles to the axis of the next joint."""

    sin_tilt: float  # of z, about x of the frame before
    cos_tilt: float  # of z, about x of the frame before
    sin_turn: float  # of x at mid-stroke, about z, from x of the frame before
    cos_turn: float  # of x at mid-stroke, about z, from x of the frame before
    place: Vector  # position of its origin in the frame before, m
    body: RigidBody


class ChainParameters(NamedTuple):
    """Parameters of an arm in space, without payload."""

    base: Axes  # the frame before the first link, which stands at the base's origin
    links: tuple[ChainLink, ...]  # from base to tip
    armatures: tuple[float, ...]  # inertia that rotates with the joints' velocities alone, as the mass matrix, kg m2
    tool: Vector  # position of the payload in the frame of the last link, m
    gravity: Vector  # m/s2


class LinkFrame(NamedTuple):
    """A frame of a link in the frame of the base."""

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


class _FrameRow(NamedTuple):
    # One component of the vectors of a frame.
    x: float
    y: float
    z: float
    origin: float


@law
def _turn_from_mid_stroke(link, sin, cos):
    return sin * link.cos_turn + cos * link.sin_turn, cos * link.cos_turn - sin * link.sin_turn


@law
def _base_rows(base, zero):
    """Return the rows of the base's frame, for the components x, y and z; `zero` has the lanes of the angles."""
    x, y, z = base.x, base.y, base.z
    return (
        _FrameRow(x.x + zero, y.x + zero, z.x + zero, zero),
        _FrameRow(x.y + zero, y.y + zero, z.y + zero, zero),
        _FrameRow(x.z + zero, y.z + zero, z.z + zero, zero),
    )


@law
def _next_row(row, link, sin, cos):
    """Return a row of the frame of a link from that of the link before it, at sine and cosine of the joint's angle."""
    x, y, z, at = row.x, row.y, row.z, link.place
    level = link.cos_tilt * y + link.sin_tilt * z
    origin = (at.x * x + at.y * y) + (at.z * z + row.origin)
    return _FrameRow(cos * x + sin * level, cos * level - sin * x, link.cos_tilt * z - link.sin_tilt * y, origin)


@law
def _frame(x, y, z):
    """Return the frame of its rows for the components x, y and z."""
    return LinkFrame(
        Axes(Vector(x.x, y.x, z.x), Vector(x.y, y.y, z.y), Vector(x.z, y.z, z.z)), Vector(x.origin, y.origin, z.origin)
    )


@composition
def _frame_from_rows(rows):
    x, y, z = unpacked(rows, COMPONENTS_LIKE)
    return _frame(x, y, z)


@composition
def frames(arm, q):
    """Return the frames of all links in that of the base at angles (rad), both tuples."""
    sines, cosines = sincos(wrap_angle(abreast(q)))
    sines, cosines = _turn_from_mid_stroke(abreast(arm.links), sines, cosines)
    sin, cos, links = slots(apart(sines, q)), slots(apart(cosines, q)), slots(arm.links)
    rows = slots(q, packed(_base_rows(arm.base, in_lanes(0.0, sin[0]))))
    for i in range(len(q)):
        rows[i] = each(_next_row, rows[max(i - 1, 0)], links[i], sin[i], cos[i])
    return each(_frame_from_rows, gather(q, rows))


@law
def _screw(frame):
    return _Screw(frame.axes.z, cross(frame.origin, frame.axes.z))


@law
def _add_payload(link, payload, tool):
    """Return a link with a payload (kg) added at the position `tool` in its frame, m."""
    turns = link.sin_tilt, link.cos_tilt, link.sin_turn, link.cos_turn
    return ChainLink(*turns, link.place, add_point_mass(link.body, payload, tool))


@composition
def _links_with_payload(arm, payload):
    """Return the lanes of all links, with the payload (kg) added to the last one.

    In the last link's own frame the payload is the same at all angles: it is added once for many steps.
    """
    links = slots(arm.links)
    last = len(arm.links) - 1
    links[last] = _add_payload(links[last], payload, arm.tool)
    return abreast(gather(arm.links, links))


@law
def _body(link, frame):
    return transform_body(link.body, frame.axes, frame.origin)


@law
def _unit_momentum(body, screw):
    """Return the momentum (a wrench about the base's origin) of a body at unit velocity of a joint with this screw."""
    z, s = screw.z, screw.s
    return _Wrench(
        add_vectors(apply_inertia(body.J, z), cross(body.h, s)), add_vectors(scale_vector(body.m, s), cross(z, body.h))
    )


@law
def _joint_torque(screw, wrench):
    """Return the torque of a wrench about a joint, N m."""
    return dot(screw.z, wrench.n) + dot(screw.s, wrench.f)


@law
def _joint_twist(screw, v):
    return _Twist(scale_vector(v, screw.z), scale_vector(v, screw.s))


@law
def _joint_acceleration(twist, screw, v):
    """Return the velocity-product acceleration (twist) of a joint at velocity v (rad/s), whose axis moves.

    The joint's own rotation adds nothing, so that the twist after it may stand for that before.
    """
    z, s = scale_vector(v, screw.z), scale_vector(v, screw.s)
    return _Twist(cross(twist.w, z), add_vectors(cross(twist.w, s), cross(twist.u, z)))


@law
def _required_wrench(body, twist, rate):
    """Return the wrench about the base's origin that accelerates a body at a rate (twist acceleration).

    c is the acceleration of the body's point at the origin: f = m c + W h, and n is h x c and the product of J and W.
    """
    w, a, h, J = twist.w, rate.w, body.h, body.J
    c = add_vectors(rate.u, cross(w, twist.u))
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
    return _Wrench(add_vectors(n, cross(h, c)), add_vectors(scale_vector(body.m, c), f))


@law
def _gravity_torque(momentum, gravity):
    """Return the torque of a body's weight about a joint, N m, proportional to its unit momentum."""
    return dot(momentum.f, gravity)


@composition
def _repeat(item, like):
    return abreast(gather(like, slots(like, item)))


@law
def _tool_position(tool, frame):
    return add_vectors(frame.origin, to_parent_frame(frame.axes, tool))


@composition
def dynamics(arm, payload, q, v):
    """Return mass matrix, torques of velocities and of gravity (see `ArmLaws`)."""
    # All links side by side, in lanes.
    placed, n = abreast(frames(arm, q)), len(q)
    bodies = _body(_links_with_payload(arm, payload), placed)
    screw, speed = _screw(placed), abreast(v)
    twist = sums_up_to(_joint_twist(screw, speed), q)
    rate = sums_up_to(_joint_acceleration(twist, screw, speed), q)
    composites, wrenches = sums_from(bodies, q), sums_from(_required_wrench(bodies, twist, rate), q)
    momentum = _unit_momentum(composites, screw)
    moving, pulled = negate(_joint_torque(screw, wrenches)), _gravity_torque(momentum, _repeat(arm.gravity, q))
    momenta = slots(apart(momentum, q))
    M = slots(arm.armatures)
    for j in range(n):
        column = slots(apart(_joint_torque(screw, _repeat(momenta[j], q)), q))
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
    """Return the positions of the joints and of the tool (see `ArmLaws`)."""
    placed = frames(arm, q)
    hand = placed[len(q) - 1]
    return *each(_origin, placed), _tool_position(arm.tool, hand)


@law
def _axis(frame):
    return frame.axes.z


@composition
def axis_directions(arm, q):
    """Return the unit vectors of the joints' axes in the base frame at joint angles q, rad, a tuple (see `ArmLaws`)."""
    return each(_axis, frames(arm, q))
