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

from typing import NamedTuple

from layflat.jit import law
from layflat.physics.trig import sincos


class OneLink(NamedTuple):
    """Parameters of an arm with one joint; everything but the payload is lumped into inertia and first moment."""

    inertia: float
    moment: float
    length: float
    gravity_x: float
    gravity_y: float


class TwoLink(NamedTuple):
    """Parameters of an arm with two joints, without payload (symbols in the module's table)."""

    a: float
    b: float
    c: float
    moment_1: float
    moment_2: float
    length_1: float
    length_2: float
    elbow: float
    gravity_x: float
    gravity_y: float


class LevelTwoLink(NamedTuple):
    """Parameters of an arm with two joints that moves in a level plane: gravity does no work."""

    a: float
    b: float
    c: float
    length_1: float
    length_2: float
    elbow: float


@law
def one_link_mass(arm, m_p):
    """Inertia about the joint, kg m2."""
    return arm.inertia + m_p * arm.length * arm.length


@law
def one_link_gravity(arm, m_p, q):
    """Torque of gravity on the joint, N m."""
    sin_q, cos_q = sincos(q)
    return (arm.moment + m_p * arm.length) * (arm.gravity_y * cos_q - arm.gravity_x * sin_q)


@law
def two_link_mass(arm, m_p, sin_2, cos_2):
    """M_11, M_12, M_22 and the Coriolis coefficient h = b sin(q_2 + e), from sine and cosine of q_2 + e."""
    b = arm.b + m_p * arm.length_1 * arm.length_2
    c = arm.c + m_p * arm.length_2 * arm.length_2
    a = arm.a + m_p * (arm.length_1 * arm.length_1 + arm.length_2 * arm.length_2)
    return a + 2.0 * b * cos_2, c + b * cos_2, c, b * sin_2


@law
def two_link_coriolis(h, v_1, v_2):
    """Torques that the velocities cause, N m."""
    return h * v_2 * (2.0 * v_1 + v_2), -h * v_1 * v_1


@law
def two_link_gravity(arm, m_p, sin_1, cos_1, sin_2, cos_2):
    """Torques of gravity on both joints, N m, from sine and cosine of q_1 and of q_2 + e."""
    sin_t = sin_1 * cos_2 + cos_1 * sin_2
    cos_t = cos_1 * cos_2 - sin_1 * sin_2
    first = (arm.moment_1 + m_p * arm.length_1) * (arm.gravity_y * cos_1 - arm.gravity_x * sin_1)
    second = (arm.moment_2 + m_p * arm.length_2) * (arm.gravity_y * cos_t - arm.gravity_x * sin_t)
    return first + second, second


@law
def one_link_tip(arm, q_1):
    """Position of the tip, m, x along link 1 at mid-stroke."""
    sin_1, cos_1 = sincos(q_1)
    return arm.length * cos_1, arm.length * sin_1


@law
def two_link_tip(arm, q_1, q_2):
    """As `one_link_tip`."""
    sin_1, cos_1 = sincos(q_1)
    sin_2, cos_2 = sincos(q_2 + arm.elbow)
    x = arm.length_1 * cos_1 + arm.length_2 * (cos_1 * cos_2 - sin_1 * sin_2)
    y = arm.length_1 * sin_1 + arm.length_2 * (sin_1 * cos_2 + cos_1 * sin_2)
    return x, y
