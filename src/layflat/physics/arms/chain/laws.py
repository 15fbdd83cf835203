"""Rigid arms in space: serial chains of links, of any number of joints.

Everything is seen from the base. A motion is the velocity of rotation and that of the point of the body that passes the
base's origin; a force is a moment about that origin and a force. Bodies that move as one are added up from the tip.

| symbol | meaning | unit |
|---|---|---|
| z | axis of a joint | 1 |
| s | velocity of the origin with unit velocity of a joint: p x z, where p is a point of its axis | m |
| w, u | velocity of rotation, and of the origin | rad/s, m/s |
| a, b | accelerations: of rotation, and of the origin | rad/s2, m/s2 |
| n, f | moment about the origin, and force | N m, N |
| L, P | angular momentum about the origin, and momentum | N m s, N s |

Source: composite bodies and recursive Newton-Euler in spatial coordinates (featherstone2008, chapters 5 and 6).
"""

from typing import Any, NamedTuple

from layflat.jit import composition, law
from layflat.lanes import abreast, apart, each, gather, slots, sums_from, sums_up_to
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


class _Beside(NamedTuple):
    # A frame with the components of each vector side by side.
    x: Any
    y: Any
    z: Any
    origin: Any


@composition
def _beside(vector):
    return abreast((vector.x, vector.y, vector.z))


@composition
def _thrice(number):
    return abreast((number, number, number))


@law
def _offset(link, sin, cos):
    return sin * link.cos_turn + cos * link.sin_turn, cos * link.cos_turn - sin * link.sin_turn


@composition
def _steps(link, sin, cos):
    # All numbers by which the next frame comes from one, for its three components.
    at = link.place
    tilt = _thrice(link.sin_tilt), _thrice(link.cos_tilt)
    return (*tilt, _thrice(sin), _thrice(cos), _thrice(at.x), _thrice(at.y), _thrice(at.z))


@law
def _beyond(frame, sin_tilt, cos_tilt, sin, cos, along_x, along_y, along_z):
    x, y, z = frame.x, frame.y, frame.z
    level = cos_tilt * y + sin_tilt * z
    origin = (along_x * x + along_y * y) + (along_z * z + frame.origin)
    return _Beside(cos * x + sin * level, cos * level - sin * x, cos_tilt * z - sin_tilt * y, origin)


@law
def _frame(x, y, z):
    return Frame(
        Axes(Vector(x.x, y.x, z.x), Vector(x.y, y.y, z.y), Vector(x.z, y.z, z.z)), Vector(x.origin, y.origin, z.origin)
    )


@composition
def _parted(frame):
    x, y, z = apart(frame, THREE)
    return _frame(x, y, z)


@composition
def frames(arm, q):
    """Return the frames of all links at angles (rad), a tuple."""
    sines, cosines = sincos(within_half_a_turn(abreast(q)))
    sines, cosines = _offset(abreast(arm.links), sines, cosines)
    sin, cos, links = slots(apart(sines, q)), slots(apart(cosines, q)), slots(arm.links)
    zero = _thrice(0.0 * sin[0])
    base = _Beside(_beside(arm.base.x) + zero, _beside(arm.base.y) + zero, _beside(arm.base.z) + zero, zero)
    found = slots(q, base)
    for i in range(len(q)):
        s_t, c_t, s, c, x, y, z = _steps(links[i], sin[i], cos[i])
        found[i] = _beyond(found[max(i - 1, 0)], s_t, c_t, s, c, x, y, z)
    return each(_parted, gather(q, found))


@law
def _screw(frame):
    return _Screw(frame.axes.z, cross(frame.origin, frame.axes.z))


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
    # Moment and force that a body needs for its accelerations, of which c is that of its point at the origin.
    w, a = twist.w, rate.w
    c = plus(rate.u, cross(w, twist.u))
    n = plus(plus(applied(body.J, a), cross(body.h, c)), cross(w, applied(body.J, w)))
    return _Wrench(n, plus(scaled(body.m, c), plus(cross(a, body.h), cross(w, cross(w, body.h)))))


@law
def _minus(x):
    return -x


@law
def _pull(pushed, gravity):
    # Of the weight of a body about a joint: what it does is in proportion to the momentum.
    return dot(pushed.f, gravity)


@composition
def _loads(payload, q):
    # What the links carry: the last one the payload.
    masses = slots(q, 0.0 * payload)
    masses[len(q) - 1] = payload
    return abreast(gather(q, masses))


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
    link = _body(abreast(arm.links), placed)
    own = with_point(link, _loads(payload, q), _held(_for_all(arm.tool, q), placed))
    screw, speed = _screw(placed), abreast(v)
    twist = sums_up_to(_turning(screw, speed), q)
    rate = sums_up_to(_bent(twist, screw, speed), q)
    carried, needed = sums_from(own, q), sums_from(_needed(own, twist, rate), q)
    pushed = _pushed(carried, screw)
    moving, pulled = _minus(_on(screw, needed)), _pull(pushed, _for_all(arm.gravity, q))
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
