"""Pictures of a sized arm: in mid-stroke, and among others for its task."""

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from layflat.design.arm.sizing import SizedArm
from layflat.design.arm.trade_off import Trial, undominated
from layflat.motion.kinematics import Kinematics

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def arm_picture(arm: SizedArm) -> "Figure":
    """Draw an arm in mid-stroke, from the side and from above, with the ends of its task's moves."""
    from layflat.plot.arms import Arm, Body, arm_figure  # noqa: PLC0415  # matplotlib takes long to import

    kinematics = Kinematics(arm.machine)
    (places,), (axes,) = kinematics.joints(np.zeros((1, len(arm.parts))))
    joints = [arm.machine.joint[part.task.name] for part in arm.parts]
    halves = [0.5 * joint.body.height * axis for joint, axis in zip(joints, axes, strict=True)]
    bodies = [
        Body(place - half, place + half, joint.cylinder.diameter)
        for place, half, joint in zip(places[:-1], halves, joints, strict=True)
    ]
    tubes = [
        Body(begin, end, part.tube.diameter)
        for begin, end, part in zip(places[:-1], places[1:], arm.parts, strict=True)
    ]
    ends = kinematics.tip(np.concatenate([arm.moves.starts, arm.moves.ends]))
    return arm_figure(Arm(bodies, tubes, ends), arm.machine.name)


def sizes_picture(arm: SizedArm, trials: Sequence[Trial]) -> "Figure":
    """Draw masses of trials over the time of a move, a curve a pressure, with the arm that they come from."""
    from layflat.plot.arms import Sizes, sizes_figure  # noqa: PLC0415  # matplotlib takes long to import

    marked = zip(trials, undominated(trials), strict=True)
    sizes = []
    for pressure, group in groupby(marked, lambda one: one[0].supply):
        of, best = zip(*group, strict=True)
        times, masses = (np.array(column) for column in zip(*((one.time, one.mass) for one in of), strict=True))
        sizes.append(Sizes(pressure / 1e5, times, masses, np.array(best, dtype=float)))
    return sizes_figure(sizes, (float(arm.moves.times.mean()), arm.mass))
