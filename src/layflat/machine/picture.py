"""Figure of a machine: its arm in mid-stroke and at the ends of its strokes, and where its tip goes."""

from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array
from layflat.machine import parameters
from layflat.machine.model import Machine
from layflat.physics.arms import points_in_space

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN_TIPS = 250  # random configurations whose tips are drawn


def draw_machine(machine: Machine) -> "Figure":
    """Draw a machine's arm, in the plane or from above and from the side, with positions of its tip."""
    from layflat.plot.arms import workspace_figure  # noqa: PLC0415  # matplotlib takes long to import
    from layflat.plot.style import add_caption  # noqa: PLC0415

    half = np.array([0.5 * joint.stops.working_stroke for joint in machine.joints.values()])
    samples = np.random.default_rng(0).uniform(-half, half, (SHOWN_TIPS, len(half)))
    arms = {
        "lower ends of the strokes": _joint_positions(machine, -half),
        "mid-stroke": _joint_positions(machine, 0.0 * half),
        "upper ends of the strokes": _joint_positions(machine, half),
    }
    tips = np.array([_joint_positions(machine, angles)[-1] for angles in samples])
    figure = workspace_figure(arms, tips, ("xy", "xz") if np.ptp(tips[:, 2]) > 0.0 else ("xy",))
    return add_caption(figure, f"{machine.name}: {machine.title}")


def _joint_positions(machine: Machine, angles: Array) -> Array:
    """Return the positions of joints and tip, (joints + 1, 3), m, at angles (joints,), rad."""
    return np.array(points_in_space(parameters.arm(machine), tuple(angles.tolist())))
