"""Arms in space: from the description of a serial chain of joints and links to the parameters of its laws.

Every frame is rotated such that its joint turns about z. The laws need x at right angles to the axis of the next joint
as well, so that each frame comes from the one before by a tilt about x and a rotation about z (Denavit and Hartenberg's
idea; origins stay where they are, since common normals of axes that are nearly parallel lie far away).

Described values may be arrays in place of numbers, an item a run of an ensemble. The rigid bodies of an arm stay in
the described frames.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from layflat.lazy import numpy as np
from layflat.physics.arms.bodies import (
    RigidArm,
    RigidLink,
    inertia_matrix,
    lump_bodies,
    point_mass_body,
    rotation_from_angles,
)
from layflat.physics.arms.chain.description import MIN_DIRECTION_LENGTH, ChainPart, LinkPart, six_moments
from layflat.physics.arms.chain.laws import ChainLink, ChainParameters, axis_directions, dynamics, points
from layflat.physics.arms.chain.space import (
    Axes,
    RigidBody,
    Symmetric,
    Vector,
    add_point_mass,
    compose_axes,
    cross,
    dot,
    merge_bodies,
    to_parent_frame,
    transform_body,
    transpose_axes,
)
from layflat.physics.arms.kind import ArmKind, ArmLaws

ZERO_VECTOR = Vector(0.0, 0.0, 0.0)
IDENTITY_AXES = Axes(Vector(1.0, 0.0, 0.0), Vector(0.0, 1.0, 0.0), Vector(0.0, 0.0, 1.0))


def axes_from_angles(turn: Sequence[Any]) -> Axes:
    """Return the axes of a frame that is rotated about x, then y, then z of the parent frame, by angles in rad."""
    (s_a, s_b, s_c), (c_a, c_b, c_c) = np.sin(turn), np.cos(turn)
    return Axes(
        Vector(c_b * c_c, c_b * s_c, -s_b),
        Vector(s_a * s_b * c_c - c_a * s_c, s_a * s_b * s_c + c_a * c_c, s_a * c_b),
        Vector(c_a * s_b * c_c + s_a * s_c, c_a * s_b * s_c - s_a * c_c, c_a * c_b),
    )


def axes_along(axis: Sequence[Any]) -> Axes:
    """Return the axes of a frame whose z lies along an axis (of any length), and whose x has no z in the parent.

    They are the parent's where the axis is its z.
    """
    x, y, z = np.array(axis, float) / np.sqrt(np.sum(np.square(axis), axis=0))
    across = np.hypot(x, y)
    upright, per = across < MIN_DIRECTION_LENGTH, 1.0 / np.maximum(across, MIN_DIRECTION_LENGTH)
    level: tuple[Any, Any] = np.where(upright, 1.0, -y * per), np.where(upright, 0.0, x * per)
    first = Vector(*level, 0.0 * x)
    third = Vector(x, y, z)
    return Axes(first, cross(third, first), third)


def _rotor_body(inertia: Any) -> RigidBody:
    """Return a rotor as a body: a thin disk about z with this inertia, kg m2."""
    return RigidBody(0.0, ZERO_VECTOR, Symmetric(0.5 * inertia, 0.5 * inertia, inertia, 0.0, 0.0, 0.0))


def _loaded_body(part: LinkPart, carried: Any, at: Vector) -> RigidBody:
    """Return a link in its own frame, with a point mass `carried` (kg) at a position (m)."""
    about_centre = RigidBody(part.mass, ZERO_VECTOR, Symmetric(*six_moments(part.inertia)))
    body: RigidBody = add_point_mass(transform_body(about_centre, IDENTITY_AXES, Vector(*part.centre)), carried, at)
    return body


class AlignedLink(NamedTuple):
    """A link in a frame whose z is the axis of its joint, at mid-stroke."""

    axes: Axes  # of this frame, in the frame of the link before
    place: Vector  # position of its origin there, m
    body: RigidBody


def _common_normal(z: Vector, after: Vector, default: Vector) -> Vector:
    """Return the unit vector at right angles to an axis and the next one; the default where these are parallel."""
    normal = cross(z, after)
    length = np.sqrt(dot(normal, normal))
    per, parallel = 1.0 / np.maximum(length, MIN_DIRECTION_LENGTH), length < MIN_DIRECTION_LENGTH
    components: list[Any] = [np.where(parallel, old, per * new)[()] for old, new in zip(default, normal, strict=True)]
    return Vector(*components)


def build_chain(
    jointed: Sequence[AlignedLink], armatures: tuple[Any, ...], tool: Vector, gravity: Vector
) -> ChainParameters:
    """Return the parameters of an arm from its links.

    Args:
        jointed: the links, from base to tip.
        armatures: upper triangle of the inertia that rotates with the joints' velocities alone, kg m2.
        tool: position of payload and tip in the frame of the last link, m.
        gravity: gravity in the frame of the base, m/s2.
    """
    links, before, base = [], IDENTITY_AXES, jointed[0].axes
    at = IDENTITY_AXES  # the frame of the link before, as `before` has it: turned about z alone
    for i, (axes, place, body) in enumerate(jointed):
        aligned = compose_axes(transpose_axes(at), axes) if i else IDENTITY_AXES
        after = jointed[i + 1].axes.z if i + 1 < len(jointed) else aligned.x
        first = _common_normal(Vector(0.0, 0.0, 1.0), after, Vector(1.0, 0.0, 0.0))
        at = Axes(first, cross(IDENTITY_AXES.z, first), IDENTITY_AXES.z)
        turned = to_parent_frame(aligned, first)
        tilt = -aligned.z.y, aligned.z.z
        level = Vector(0.0, tilt[1], tilt[0])  # y after the tilt
        where = to_parent_frame(transpose_axes(before if i else base), place)
        links.append(
            ChainLink(*tilt, dot(turned, level), turned.x, where, transform_body(body, transpose_axes(at), ZERO_VECTOR))
        )
        before = at
    return ChainParameters(base, tuple(links), armatures, to_parent_frame(transpose_axes(before), tool), gravity)


def parameters(described: ChainPart, joints: Sequence[Any]) -> ChainParameters:
    """Return the parameters of the described arm, without payload.

    Args:
        described: description of the arm.
        joints: descriptions of its joints, from base to tip; see `bodies`.
    """
    parts = [described.link[name] for name in described.joints]
    carries = described.bodies == "carried"
    loads = [(joint.body.mass if carries else 0.0) for joint in joints[1:]] + [0.0]
    ends = [Vector(*part.position) for part in parts[1:]] + [ZERO_VECTOR]
    jointed, before = [], IDENTITY_AXES
    for part, carried, end in zip(parts, loads, ends, strict=True):
        aligned = axes_along(part.axis)
        body = merge_bodies(
            transform_body(_loaded_body(part, carried, end), transpose_axes(aligned), ZERO_VECTOR),
            _rotor_body(part.rotor_inertia),
        )
        axes = compose_axes(before, compose_axes(axes_from_angles(part.rotation), aligned))
        jointed.append(AlignedLink(axes, to_parent_frame(before, Vector(*part.position)), body))
        before = transpose_axes(aligned)
    rows = range(len(parts))
    armatures = tuple(parts[i].armature if i == j else 0.0 for i in rows for j in rows if i <= j)
    return build_chain(jointed, armatures, to_parent_frame(before, Vector(*described.tool)), Vector(*described.gravity))


def bodies(described: ChainPart, joints: Sequence[Any]) -> RigidArm:
    """Return the arm as rigid bodies in the described frames, from base to tip, without payload.

    A link's inertia includes that of its rotor, which has no mass. With `bodies = "carried"` a link also includes the
    body of the next joint, as a point mass at that joint; the body of the first joint is fixed to the base.

    Args:
        described: description of the arm; no value may be an array.
        joints: descriptions of its joints, from base to tip.
    """
    parts = [described.link[name] for name in described.joints]
    carries = described.bodies == "carried"
    loads = [(joint.body.mass if carries else 0.0) for joint in joints[1:]] + [0.0]
    ends = [part.position for part in parts[1:]] + [described.tool]
    links = []
    for part, carried, end in zip(parts, loads, ends, strict=True):
        axis = np.array(part.axis, float) / np.linalg.norm(part.axis)
        link = part.mass, np.array(part.centre, float), inertia_matrix(six_moments(part.inertia))
        # The rotor is a thin disk about the axis; as it has no mass of its own, it may be anywhere.
        disk = 0.5 * part.rotor_inertia * (np.eye(3) + np.outer(axis, axis))
        mass, centre, inertia = lump_bodies([link, point_mass_body(carried, end), (0.0, np.zeros(3), disk)])
        place, axes = np.array(part.position, float), rotation_from_angles(part.rotation)
        links.append(RigidLink(place, axes, axis, mass, centre, inertia, part.armature, part.shapes))
    gravity = np.array(described.gravity, float)
    return RigidArm(
        tuple(links), np.array(described.tool, float), rotation_from_angles(described.tool_rotation), gravity
    )


KIND = ArmKind(
    name="chain",
    description=ChainPart,
    parameters=parameters,
    bodies=bodies,
    parameter_types=(ChainParameters,),
    laws={
        ChainParameters: ArmLaws(joints=None, dynamics=dynamics, points=points, axes=3, axis_directions=axis_directions)
    },
)
