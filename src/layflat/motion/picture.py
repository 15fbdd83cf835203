"""A planned motion as a picture."""

from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.inverse import Inverse
from layflat.motion.kinematics import Kinematics, tip_position
from layflat.motion.path import half_strokes
from layflat.motion.plan import Plan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from layflat.plot.motions import View

INSTANTS = 2001  # that are drawn
POINTS = 61  # on a side of an outline


def picture(plan: Plan) -> "Figure":
    """Draw a planned motion: the tip's way, angles, velocities and torques with their limits."""
    from layflat.plot.motions import Curve, Joint, motion_figure  # noqa: PLC0415  # matplotlib loads slowly

    machine, able, motion = plan.machine, plan.able, plan.trajectory
    time = np.linspace(0.0, max(motion.duration, machine.cycle), INSTANTS)
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
    return motion_figure(time, motion.begins, _views(plan, states.angles), joints)


def _views(plan: Plan, angles: Array) -> "list[View]":
    """Return what is seen of a motion: in the plane, or from above and from the side."""
    from layflat.plot.motions import View  # noqa: PLC0415

    machine, ends, tip = plan.machine, angles[[0, -1]], tip_position(plan.machine, angles)
    left = [np.array(segment.left.place) for segment in plan.segments if segment.left is not None]
    arms = Kinematics(machine).joints(ends)[0]
    if tip.shape[1] == 2:
        return [View("xy", tip, outlines(machine), list(arms[:, :, :2]), left)]
    base = np.zeros((len(arms), 1, 3))
    arms = np.concatenate([base, arms], axis=1)
    known = Inverse(machine).tips
    return [
        View(
            "xyz"[a] + "xyz"[b],
            tip[:, [a, b]],
            [hull(known[:, [a, b]])],
            list(arms[:, :, [a, b]]),
            [at[[a, b]] for at in left],
        )
        for a, b in ((0, 1), (0, 2))
    ]


def hull(points: Array) -> Array:
    """Return the convex hull of points (points, 2) as a closed line."""
    corners = points[ConvexHull(points).vertices]
    return np.vstack([corners, corners[:1]])


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
