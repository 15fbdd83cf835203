"""Figure of a sized arm."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from layflat.design.arm.described import SizedPart
from layflat.design.arm.moves import TaskMoves
from layflat.machine import Machine
from layflat.motion.kinematics import Kinematics

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_arm(machine: Machine, parts: Sequence[SizedPart], moves: TaskMoves) -> "Figure":
    """Draw an arm in mid-stroke, from the side and from above, with the ends of its task's moves.

    Args:
        machine: machine with the sized arm.
        parts: its joints and links, from base to tip.
        moves: moves of the task.
    """
    from layflat.plot.arms import DrawnArm, DrawnCylinder, arm_figure  # noqa: PLC0415  # matplotlib takes long to import

    kinematics = Kinematics(machine)
    (places,), (axes,) = kinematics.joints(np.zeros((1, len(parts))))
    joints = [machine.joint[part.task.name] for part in parts]
    halves = [0.5 * joint.body.height * axis for joint, axis in zip(joints, axes, strict=True)]
    bodies = [
        DrawnCylinder(place - half, place + half, joint.cylinder.diameter)
        for place, half, joint in zip(places[:-1], halves, joints, strict=True)
    ]
    tubes = [
        DrawnCylinder(begin, end, part.tube.diameter)
        for begin, end, part in zip(places[:-1], places[1:], parts, strict=True)
    ]
    ends = kinematics.tip(np.concatenate([moves.starts, moves.ends]))
    return arm_figure(DrawnArm(bodies, tubes, ends), machine.name)
