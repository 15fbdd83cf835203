"""Figure of a planned motion."""

from collections.abc import Sequence
from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.dynamics import hose_torques
from layflat.motion.inverse import InverseKinematics
from layflat.motion.kinematics import Kinematics, tip_position
from layflat.motion.limits import joint_capabilities
from layflat.motion.path import half_strokes
from layflat.motion.trajectory import MotionSequence

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from layflat.plot.motions import MotionView

DRAWN_INSTANTS = 2001  # at which curves are drawn
OUTLINE_POINTS = 61  # on each side of an outline


def draw_motion(machine: Machine, motion: MotionSequence, payload: float, exits: Sequence[Array] = ()) -> "Figure":
    """Draw a motion of an arm: the tip's path, angles, velocities and torques with their limits.

    Args:
        machine: machine with the arm.
        motion: a part for each segment.
        payload: kg.
        exits: positions at which targets leave the arm's reach, (axes,) each, m.
    """
    from layflat.plot.motions import JointCurves, LimitedCurve, motion_figure  # noqa: PLC0415  # matplotlib loads slowly

    capabilities = joint_capabilities(machine)
    time = np.linspace(0.0, max(motion.duration, machine.cycle), DRAWN_INSTANTS)
    states, half = motion.states(time), np.degrees(half_strokes(machine))
    torques = hose_torques(machine, capabilities, states, payload)
    angles, velocities, speeds = (
        np.degrees(states.angles),
        np.degrees(states.velocities),
        np.degrees(capabilities.speed),
    )
    joints = {
        name: JointCurves(
            LimitedCurve(angles[:, j], -half[j], half[j]),
            LimitedCurve(velocities[:, j], -speeds[j], speeds[j]),
            LimitedCurve(torques[:, j], capabilities.min_torque[j], capabilities.torque[j]),
        )
        for j, name in enumerate(machine.joints)
    }
    return motion_figure(time, motion.start_times, _motion_views(machine, states.angles, exits), joints)


def _motion_views(machine: Machine, angles: Array, exits: Sequence[Array]) -> "list[MotionView]":
    """Return the views of a motion: of the plane, or from above and from the side."""
    from layflat.plot.motions import MotionView  # noqa: PLC0415

    ends, tip = angles[[0, -1]], tip_position(machine, angles)
    arms = Kinematics(machine).joints(ends)[0]
    if tip.shape[1] == 2:
        return [MotionView("xy", tip, reach_outlines(machine), list(arms[:, :, :2]), exits)]
    base = np.zeros((len(arms), 1, 3))
    arms = np.concatenate([base, arms], axis=1)
    workspace = InverseKinematics(machine).tips
    return [
        MotionView(
            "xyz"[a] + "xyz"[b],
            tip[:, [a, b]],
            [convex_hull(workspace[:, [a, b]])],
            list(arms[:, :, [a, b]]),
            [position[[a, b]] for position in exits],
        )
        for a, b in ((0, 1), (0, 2))
    ]


def convex_hull(points: Array) -> Array:
    """Return the convex hull of points (points, 2) as a closed line."""
    corners = points[ConvexHull(points).vertices]
    return np.vstack([corners, corners[:1]])


def reach_outlines(machine: Machine) -> list[Array]:
    """Return outlines of a planar arm's reach, (points, 2), m: one a side of the elbow, or the arc of one joint."""
    half = half_strokes(machine)
    if len(half) == 1:
        return [tip_position(machine, np.linspace(-half, half, OUTLINE_POINTS))]
    elbow = machine.arm.elbow
    ends = np.clip(np.array([-pi, 0.0, pi]) - elbow, -half[1], half[1])
    return [_reach_outline(machine, half[0], low, high) for low, high in pairwise(ends) if low < high]


def _reach_outline(machine: Machine, half_stroke: float, elbow_min: float, elbow_max: float) -> Array:
    """Return the tip positions, (points, 2), m, along the border of a rectangle of joint angles.

    Joint 1 is within +-half_stroke, joint 2 from elbow_min to elbow_max, rad.
    """
    corners = np.array(
        [
            [-half_stroke, elbow_min],
            [half_stroke, elbow_min],
            [half_stroke, elbow_max],
            [-half_stroke, elbow_max],
            [-half_stroke, elbow_min],
        ]
    )
    fraction = np.linspace(0.0, 1.0, OUTLINE_POINTS)[:, None]
    sides = [a + fraction * (b - a) for a, b in pairwise(corners)]
    return tip_position(machine, np.concatenate(sides))
