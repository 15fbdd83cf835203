"""A planned motion as a picture."""

from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.kinematics import links, tip_position
from layflat.motion.path import half_strokes
from layflat.motion.plan import Plan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INSTANTS = 2001  # that are drawn
POINTS = 61  # on a side of an outline


def picture(plan: Plan) -> "Figure":
    """Draw a planned motion: the tip's way in the plane, angles, velocities and torques with their limits."""
    from layflat.plot.motions import Curve, Joint, Plane, motion_figure  # noqa: PLC0415  # matplotlib loads slowly

    machine, able, motion = plan.machine, plan.able, plan.trajectory
    time = np.linspace(0.0, motion.duration, INSTANTS)
    states, torques, half = motion.states(time), plan.torques(motion, time), np.degrees(half_strokes(machine))
    angles, velocities, speeds = np.degrees(states.angles), np.degrees(states.velocities), np.degrees(able.speed)
    joints = {
        name: Joint(
            Curve(angles[:, j], -half[j], half[j]),
            Curve(velocities[:, j], -speeds[j], speeds[j]),
            Curve(torques[:, j], able.least_torque[j], able.torque[j]),
        )
        for j, name in enumerate(machine.joints)
    }
    arms = [_links(machine, states.angles[k]) for k in (0, -1)]
    left = [segment.left.place for segment in plan.segments if segment.left is not None]
    tip = tip_position(machine, states.angles)
    return motion_figure(time, motion.begins, Plane(tip, outlines(machine), arms, left), joints)


def outlines(machine: Machine) -> list[Array]:
    """Return lines around what the tip can reach, (points, 2), m, one for each side of the elbow."""
    half = half_strokes(machine)
    if len(half) == 1:
        return [tip_position(machine, np.linspace(-half, half, POINTS))]
    elbow = machine.arm.elbow
    ends = np.clip(np.array([-pi, 0.0, pi]) - elbow, -half[1], half[1])
    return [_outline(machine, half[0], low, high) for low, high in pairwise(ends) if low < high]


def _outline(machine: Machine, half: float, low: float, high: float) -> Array:
    """Return the image of the border of a rectangle of joint angles."""
    corners = np.array([[-half, low], [half, low], [half, high], [-half, high], [-half, low]])
    share = np.linspace(0.0, 1.0, POINTS)[:, None]
    sides = [a + share * (b - a) for a, b in pairwise(corners)]
    return tip_position(machine, np.concatenate(sides))


def _links(machine: Machine, angles: Array) -> Array:
    """Return base, elbow if any, and tip, (points, 2), m."""
    lengths, bends = links(machine)
    directions = np.cumsum(angles + bends)
    steps = lengths[:, None] * np.stack([np.cos(directions), np.sin(directions)], axis=1)
    return np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
