"""Rigid arms in a plane: mass matrix, Coriolis terms and gravity of one link and of two links.

| symbol | meaning | unit |
|---|---|---|
| q_1, q_2 | joint angles from the middle of each stroke | rad |
| e | angle of the elbow at q_2 = 0 | rad |
| l_1, l_2 | lengths of the links | m |
| m_p | payload at the tip | kg |
| a, b, c | M_11 = a + 2 b cos(q_2 + e), M_12 = c + b cos(q_2 + e), M_22 = c | kg m2 |
| S_1, S_2 | first moments of mass along link 1 and link 2 | kg m |
| g_x, g_y | gravity in the arm's plane, along and across link 1 at q_1 = 0 | m/s2 |

Source: the planar two-link arm of any textbook, e.g. Spong 2020 (key spong2020), with the masses lumped.
"""

from collections.abc import Sequence
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from layflat.description import units as u
from layflat.jit import composition, law
from layflat.lanes import halves, join
from layflat.lazy import numpy as np
from layflat.physics.arms.bodies import RigidArm, RigidLink, lump_bodies, point_mass_body, rotation_from_angles
from layflat.physics.arms.kind import NO_TORQUE, ArmKind, ArmLaws, ArmPart
from layflat.physics.trig import sincos

STANDARD_GRAVITY = 9.80665  # m/s2


class PlanarArmPart(ArmPart):
    """Description of an arm in a plane, its joints from the base to the tip."""

    kind: Literal["planar"] = "planar"
    joints: Annotated[tuple[str, ...], Field(min_length=1, max_length=2)]
    gravity: u.Gravity = Field(description="in the arm's plane; zero for an arm that moves horizontally")
    gravity_direction: u.Angle = Field(description="from link 1 at mid-stroke")
    elbow: u.Angle = Field(description="angle between the links when the second joint is in mid-stroke")


class OneLink(NamedTuple):
    """Parameters of an arm with one joint; everything but the payload is lumped into inertia and first moment."""

    inertia: float  # kg m2
    moment: float  # first moment of mass, kg m
    length: float  # m
    gravity_x: float  # g_x, m/s2
    gravity_y: float  # g_y, m/s2


class TwoLink(NamedTuple):
    """Parameters of an arm with two joints, without payload (symbols in the module's table)."""

    a: float  # in the inertia a + 2 b cos(q_2 + e) of joint 1, kg m2
    b: float  # likewise, kg m2
    c: float  # inertia of joint 2, kg m2
    moment_1: float  # S_1, kg m
    moment_2: float  # S_2, kg m
    length_1: float  # l_1, m
    length_2: float  # l_2, m
    elbow: float  # e, rad
    gravity_x: float  # g_x, m/s2
    gravity_y: float  # g_y, m/s2


class LevelTwoLink(NamedTuple):
    """Parameters of an arm with two joints that moves in a level plane: gravity does no work."""

    a: float  # in the inertia a + 2 b cos(q_2 + e) of joint 1, kg m2
    b: float  # likewise, kg m2
    c: float  # inertia of joint 2, kg m2
    length_1: float  # l_1, m
    length_2: float  # l_2, m
    elbow: float  # e, rad


def parameters(described: PlanarArmPart, joints: Sequence[Any]) -> OneLink | TwoLink | LevelTwoLink:
    """Return the parameters of the described arm, without payload; joints from base to tip."""
    g_x = described.gravity * np.cos(described.gravity_direction)
    g_y = described.gravity * np.sin(described.gravity_direction)
    first = joints[0].planar_link
    own_1 = first.rotor_inertia + first.inertia + first.mass * first.centre**2
    if len(joints) == 1:
        return OneLink(own_1, first.mass * first.centre, first.length, g_x, g_y)
    second, carried = joints[1].planar_link, joints[1].body.mass
    own_2 = second.rotor_inertia + second.inertia + second.mass * second.centre**2
    masses = (
        own_1 + own_2 + (carried + second.mass) * first.length**2,
        second.mass * first.length * second.centre,
        own_2,
    )
    if np.all(described.gravity == 0.0):
        return LevelTwoLink(*masses, first.length, second.length, described.elbow)
    return TwoLink(
        *masses,
        first.mass * first.centre + (carried + second.mass) * first.length,
        second.mass * second.centre,
        first.length,
        second.length,
        described.elbow,
        g_x,
        g_y,
    )


def bodies(described: PlanarArmPart, joints: Sequence[Any]) -> RigidArm:
    """Return the arm as rigid bodies in the plane z = 0, x along each link; the rest of gravity acts along -z."""
    g_x = described.gravity * np.cos(described.gravity_direction)
    g_y = described.gravity * np.sin(described.gravity_direction)
    carried = [joint.body.mass for joint in joints[1:]] + [0.0]
    links, at, turn = [], 0.0, 0.0
    for joint, load in zip(joints, carried, strict=True):
        link, end = joint.planar_link, (joint.planar_link.length, 0.0, 0.0)
        across = link.inertia + link.rotor_inertia
        own = link.mass, np.array([link.centre, 0.0, 0.0]), np.diag([link.rotor_inertia, across, across])
        axes, axis = rotation_from_angles((0.0, 0.0, turn)), np.array([0.0, 0.0, 1.0])
        links.append(RigidLink(np.array([at, 0.0, 0.0]), axes, axis, *lump_bodies([own, point_mass_body(load, end)])))
        at, turn = link.length, described.elbow
    across = -np.sqrt(max(STANDARD_GRAVITY**2 - g_x**2 - g_y**2, 0.0))
    return RigidArm(tuple(links), np.array([at, 0.0, 0.0]), np.eye(3), np.array([g_x, g_y, across]))


@law
def one_link_mass(arm, m_p):
    """Return the inertia about the joint, with a payload m_p (kg) at the tip, kg m2."""
    return arm.inertia + m_p * arm.length * arm.length


@law
def one_link_gravity(arm, m_p, q):
    """Return the torque of gravity on the joint, N m."""
    sin_q, cos_q = sincos(q)
    return (arm.moment + m_p * arm.length) * (arm.gravity_y * cos_q - arm.gravity_x * sin_q)


@law
def two_link_mass(arm, m_p, sin_2, cos_2):
    """Return M_11, M_12, M_22 and the Coriolis coefficient h = b sin(q_2 + e), from sine and cosine of q_2 + e."""
    b = arm.b + m_p * arm.length_1 * arm.length_2
    c = arm.c + m_p * arm.length_2 * arm.length_2
    a = arm.a + m_p * (arm.length_1 * arm.length_1 + arm.length_2 * arm.length_2)
    return a + 2.0 * b * cos_2, c + b * cos_2, c, b * sin_2


@law
def two_link_coriolis(h, v_1, v_2):
    """Return the Coriolis and centrifugal torques on both joints, N m."""
    return h * v_2 * (2.0 * v_1 + v_2), -h * v_1 * v_1


@law
def two_link_gravity(arm, m_p, sin_1, cos_1, sin_2, cos_2):
    """Return the torques of gravity on both joints, N m, from sine and cosine of q_1 and of q_2 + e."""
    sin_t = sin_1 * cos_2 + cos_1 * sin_2
    cos_t = cos_1 * cos_2 - sin_1 * sin_2
    first = (arm.moment_1 + m_p * arm.length_1) * (arm.gravity_y * cos_1 - arm.gravity_x * sin_1)
    second = (arm.moment_2 + m_p * arm.length_2) * (arm.gravity_y * cos_t - arm.gravity_x * sin_t)
    return first + second, second


@law
def _one_link(arm, m_p, q, v):  # noqa: ARG001  (signature of all arms)
    return (one_link_mass(arm, m_p),), (NO_TORQUE,), (one_link_gravity(arm, m_p, q[0]),)


@composition
def _two_link(arm, m_p, q, v):
    """Return masses (M_11, M_12, M_22), Coriolis torques (2) and gravity torques (2) of two links at q and v."""
    sines, cosines = sincos(join(q[0], q[1] + arm.elbow))
    (sin_1, sin_2), (cos_1, cos_2) = halves(sines), halves(cosines)
    M_11, M_12, M_22, coupling = two_link_mass(arm, m_p, sin_2, cos_2)
    gravity = two_link_gravity(arm, m_p, sin_1, cos_1, sin_2, cos_2)
    return (M_11, M_12, M_22), two_link_coriolis(coupling, v[0], v[1]), gravity


@composition
def _level_two_link(arm, m_p, q, v):
    """Return masses, Coriolis torques and zeros for gravity of two links in a level plane, as `_two_link`."""
    sin_2, cos_2 = sincos(q[1] + arm.elbow)
    M_11, M_12, M_22, coupling = two_link_mass(arm, m_p, sin_2, cos_2)
    return (M_11, M_12, M_22), two_link_coriolis(coupling, v[0], v[1]), (0.0, 0.0)


@law
def _one_link_points(arm, q):
    """Return the points (x, y) of joint and tip in the arm's plane, m."""
    sin_1, cos_1 = sincos(q[0])
    return (0.0, 0.0), (arm.length * cos_1, arm.length * sin_1)


@law
def _two_link_points(arm, q):
    """Return the points (x, y) of shoulder, elbow and tip in the arm's plane, m."""
    sin_1, cos_1 = sincos(q[0])
    sin_2, cos_2 = sincos(q[1] + arm.elbow)
    elbow = arm.length_1 * cos_1, arm.length_1 * sin_1
    x = arm.length_1 * cos_1 + arm.length_2 * (cos_1 * cos_2 - sin_1 * sin_2)
    y = arm.length_1 * sin_1 + arm.length_2 * (sin_1 * cos_2 + cos_1 * sin_2)
    return (0.0, 0.0), elbow, (x, y)


KIND = ArmKind(
    name="planar",
    description=PlanarArmPart,
    parameters=parameters,
    bodies=bodies,
    parameter_types=(OneLink, TwoLink, LevelTwoLink),
    laws={
        OneLink: ArmLaws(joints=1, dynamics=_one_link, points=_one_link_points),
        TwoLink: ArmLaws(joints=2, dynamics=_two_link, points=_two_link_points),
        LevelTwoLink: ArmLaws(joints=2, dynamics=_level_two_link, points=_two_link_points),
    },
)
