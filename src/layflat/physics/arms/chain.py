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

from typing import NamedTuple

from layflat.jit import composition, law
from layflat.lanes import abreast, apart, each, gather, slots
from layflat.physics.arms.space import (
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
    together,
    turned,
    with_point,
    within,
)
from layflat.physics.trig import sincos


class Link(NamedTuple):
    """A link in the frame of its joint, which turns about z."""

    axes: Axes  # of this frame at mid-stroke, in the frame of the link before
    place: Vector  # of its origin there, m
    body: Mass


class Chain(NamedTuple):
    """Parameters of an arm, without payload."""

    links: tuple[Link, ...]  # from base to tip
    rotors: tuple[float, ...]  # inertia of what turns with shafts alone, as the mass matrix, kg m2
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


@law
def _first(link, sin, cos):
    place, zero = link.place, 0.0 * sin
    return Frame(turned(link.axes, sin, cos), Vector(place.x + zero, place.y + zero, place.z + zero))


@law
def _next(frame, link, sin, cos):
    axes = turned(within(frame.axes, link.axes), sin, cos)
    return Frame(axes, plus(frame.origin, outward(frame.axes, link.place)))


@composition
def frames(arm, q):
    """Return the frames of all links at angles (rad), a tuple."""
    sines, cosines = sincos(abreast(q))
    sin, cos = apart(sines, q), apart(cosines, q)
    found = slots(each(_first, arm.links, sin, cos))
    links, sin, cos = slots(arm.links), slots(sin), slots(cos)
    for i in range(1, len(q)):
        found[i] = _next(found[i - 1], links[i], sin[i], cos[i])
    return gather(q, found)


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
def _faster(twist, more):
    return _Twist(plus(twist.w, more.w), plus(twist.u, more.u))


@law
def _bent(twist, screw, v):
    # What a joint adds to the accelerations: its axis is carried along by the links before it. (Its own turn adds
    # nothing, so that the motion after it may stand for that before.)
    z, s = scaled(v, screw.z), scaled(v, screw.s)
    return _Twist(cross(twist.w, z), plus(cross(twist.w, s), cross(twist.u, z)))


@law
def _needed(body, twist, rate):
    # Moment and force that a body needs for its accelerations.
    w, u, a, b = twist.w, twist.u, rate.w, rate.u
    L = plus(applied(body.J, w), cross(body.h, u))
    P = plus(scaled(body.m, u), cross(w, body.h))
    n = plus(plus(applied(body.J, a), cross(body.h, b)), plus(cross(w, L), cross(u, P)))
    return _Wrench(n, plus(plus(scaled(body.m, b), cross(a, body.h)), cross(w, P)))


@law
def _both(a, b):
    return _Wrench(plus(a.n, b.n), plus(a.f, b.f))


@law
def _minus(x):
    return -x


@law
def _weight(body, gravity):
    return _Wrench(cross(body.h, gravity), scaled(body.m, gravity))


@composition
def dynamics(arm, payload, q, v):
    """Return mass matrix, torques of velocities and of gravity (see `ArmLaws`)."""
    n, last = len(q), len(q) - 1
    placed = frames(arm, q)
    # All links side by side: what each of them has is found at once.
    beside, speeds = abreast(placed), abreast(v)
    bodies = slots(apart(_body(abreast(arm.links), beside), q))
    hand = placed[last]
    bodies[last] = with_point(bodies[last], payload, plus(hand.origin, outward(hand.axes, arm.tool)))
    own = abreast(gather(q, bodies))

    screw = _screw(beside)
    turns, screws = slots(apart(_turning(screw, speeds), q)), slots(apart(screw, q))
    for i in range(1, n):
        turns[i] = _faster(turns[i - 1], turns[i])
    twist = abreast(gather(q, turns))
    bends = slots(apart(_bent(twist, screw, speeds), q))
    for i in range(1, n):
        bends[i] = _faster(bends[i - 1], bends[i])
    needs = slots(apart(_needed(own, twist, abreast(gather(q, bends))), q))
    for k in range(1, n):
        j = last - k
        bodies[j] = together(bodies[j], bodies[j + 1])
        needs[j] = _both(needs[j], needs[j + 1])
    carried = gather(q, bodies)
    moving = _minus(_on(screw, abreast(gather(q, needs))))
    pulled = _on(screw, abreast(each(_weight, carried, arm.gravity)))
    pushes = slots(apart(_pushed(abreast(carried), screw), q))

    M = slots(arm.rotors)
    for j in range(n):
        for i in range(j + 1):
            place = i * n - i * (i - 1) // 2 + j - i
            M[place] = M[place] + _on(screws[i], pushes[j])
    return gather(arm.rotors, M), apart(moving, q), apart(pulled, q)
