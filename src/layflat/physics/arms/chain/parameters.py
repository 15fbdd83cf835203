"""From the described chain to the parameters of its laws: every frame is turned such that its joint turns about z.

The laws want x at right angles to the axis of the next joint as well, so that each frame comes from the one before by a
tilt about x and a turn about z (Denavit and Hartenberg's idea; origins stay where they are, since common normals of
axes that are nearly parallel lie far away).

What is described may be arrays in place of numbers, an item a run of an ensemble. The rigid bodies
of an arm stay in the described frames.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from layflat.physics.arms.bodies import RigidArm, RigidLink, lumped, moments, point, turned_by
from layflat.physics.arms.chain.description import NO_WAY, ChainPart, LinkPart, six_moments
from layflat.physics.arms.chain.laws import Chain, Link
from layflat.physics.arms.chain.space import (
    Axes,
    Mass,
    Symmetric,
    Vector,
    cross,
    dot,
    outward,
    seen_from,
    together,
    transposed,
    with_point,
    within,
)

NOWHERE = Vector(0.0, 0.0, 0.0)
LEVEL = Axes(Vector(1.0, 0.0, 0.0), Vector(0.0, 1.0, 0.0), Vector(0.0, 0.0, 1.0))


def rotation(turn: Sequence[Any]) -> Axes:
    """Axes of a frame that is turned about x, then about y, then about z of the frame around it, by angles in rad."""
    (s_a, s_b, s_c), (c_a, c_b, c_c) = np.sin(turn), np.cos(turn)
    return Axes(
        Vector(c_b * c_c, c_b * s_c, -s_b),
        Vector(s_a * s_b * c_c - c_a * s_c, s_a * s_b * s_c + c_a * c_c, s_a * c_b),
        Vector(c_a * s_b * c_c + s_a * s_c, c_a * s_b * s_c - s_a * c_c, c_a * c_b),
    )


def towards(axis: Sequence[Any]) -> Axes:
    """Axes of a frame whose z lies along an axis (of any length); not turned at all where that is z itself."""
    x, y, z = np.array(axis, float) / np.sqrt(np.sum(np.square(axis), axis=0))
    across = np.hypot(x, y)
    upright, per = across < NO_WAY, 1.0 / np.maximum(across, NO_WAY)
    level: tuple[Any, Any] = np.where(upright, 1.0, -y * per), np.where(upright, 0.0, x * per)
    first = Vector(*level, 0.0 * x)
    third = Vector(x, y, z)
    return Axes(first, cross(third, first), third)


def _rotor(inertia: Any) -> Mass:
    # A thin disk about z.
    return Mass(0.0, NOWHERE, Symmetric(0.5 * inertia, 0.5 * inertia, inertia, 0.0, 0.0, 0.0))


def _body(part: LinkPart, carried: Any, at: Vector) -> Mass:
    """A link in its own frame, with what it carries at a place."""
    about_centre = Mass(part.mass, NOWHERE, Symmetric(*six_moments(part.inertia)))
    body: Mass = with_point(seen_from(about_centre, LEVEL, Vector(*part.centre)), carried, at)
    return body


class Jointed(NamedTuple):
    """A link in any frame whose z is the axis of its joint, at mid-stroke."""

    axes: Axes  # of this frame, in the one of the link before
    place: Vector  # of its origin there, m
    body: Mass


def _square(z: Vector, after: Vector, usual: Vector) -> Vector:
    """A direction at right angles to an axis and to the one after it; the usual one where these are parallel."""
    normal = cross(z, after)
    length = np.sqrt(dot(normal, normal))
    per, parallel = 1.0 / np.maximum(length, NO_WAY), length < NO_WAY
    square: list[Any] = [np.where(parallel, old, per * new)[()] for old, new in zip(usual, normal, strict=True)]
    return Vector(*square)


def chain(jointed: Sequence[Jointed], armatures: tuple[Any, ...], tool: Vector, gravity: Vector) -> Chain:
    """Parameters of an arm from links in any frames; `tool` is in that of the last, `gravity` in that of the base."""
    links, before, base = [], LEVEL, jointed[0].axes
    at = LEVEL  # the frame of the link before, as `before` has it: turned about z alone
    for i, (axes, place, body) in enumerate(jointed):
        own = within(transposed(at), axes) if i else LEVEL
        after = jointed[i + 1].axes.z if i + 1 < len(jointed) else own.x
        first = _square(Vector(0.0, 0.0, 1.0), after, Vector(1.0, 0.0, 0.0))
        at = Axes(first, cross(LEVEL.z, first), LEVEL.z)
        turned = outward(own, first)
        tilt = -own.z.y, own.z.z
        level = Vector(0.0, tilt[1], tilt[0])  # y after the tilt
        where = outward(transposed(before if i else base), place)
        links.append(Link(*tilt, dot(turned, level), turned.x, where, seen_from(body, transposed(at), NOWHERE)))
        before = at
    return Chain(base, tuple(links), armatures, outward(transposed(before), tool), gravity)


def parameters(described: ChainPart, joints: Sequence[Any]) -> Chain:
    """Masses of the arm, without payload."""
    parts = [described.link[name] for name in described.joints]
    carries = described.bodies == "carried"
    loads = [(joint.body.mass if carries else 0.0) for joint in joints[1:]] + [0.0]
    ends = [Vector(*part.place) for part in parts[1:]] + [NOWHERE]
    jointed, before = [], LEVEL
    for part, carried, end in zip(parts, loads, ends, strict=True):
        own = towards(part.axis)
        body = together(seen_from(_body(part, carried, end), transposed(own), NOWHERE), _rotor(part.rotor_inertia))
        axes = within(before, within(rotation(part.turn), own))
        jointed.append(Jointed(axes, outward(before, Vector(*part.place)), body))
        before = transposed(own)
    rows = range(len(parts))
    armatures = tuple(parts[i].armature if i == j else 0.0 for i in rows for j in rows if i <= j)
    return chain(jointed, armatures, outward(before, Vector(*described.tool)), Vector(*described.gravity))


def bodies(described: ChainPart, joints: Sequence[Any]) -> RigidArm:
    """Return the arm as rigid bodies, without payload; each link has rotor and body of the next joint in its mass."""
    parts = [described.link[name] for name in described.joints]
    carries = described.bodies == "carried"
    loads = [(joint.body.mass if carries else 0.0) for joint in joints[1:]] + [0.0]
    ends = [part.place for part in parts[1:]] + [described.tool]
    links = []
    for part, carried, end in zip(parts, loads, ends, strict=True):
        axis = np.array(part.axis, float) / np.linalg.norm(part.axis)
        own = part.mass, np.array(part.centre, float), moments(six_moments(part.inertia))
        # The rotor is a thin disk about the axis; as it has no mass of its own, it may be anywhere.
        disk = 0.5 * part.rotor_inertia * (np.eye(3) + np.outer(axis, axis))
        mass, centre, inertia = lumped([own, point(carried, end), (0.0, np.zeros(3), disk)])
        place, axes = np.array(part.place, float), turned_by(part.turn)
        links.append(RigidLink(place, axes, axis, mass, centre, inertia, part.armature, part.shapes))
    gravity = np.array(described.gravity, float)
    return RigidArm(tuple(links), np.array(described.tool, float), turned_by(described.tool_turn), gravity)
