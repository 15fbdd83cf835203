"""The check that the output turns freely inside its cylinder, before any solid is made."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from layflat.design import design_joint
from layflat.errors import DesignError, LayflatError
from layflat.lazy import numpy as np
from layflat.solids.cams import cam_loop
from layflat.solids.places import bar_place
from layflat.solids.section import CrossSection
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.sizes import JointSizes

POSE_COUNT = 15  # of the output over its mechanical stroke
HEAD_HEIGHT = 4.0  # of the screws of the strap's clamp above the cam, mm
OFFSET_STEP = 2e-3  # between output axes that are tried as a mend, m


def check_sweep(sizes: JointSizes) -> None:
    """Raise DesignError if cam or roller meets the cylinder or the clamp bars; the message says what would mend it."""
    depth = _sweep_depth(sizes)
    if depth <= 0.0:
        return
    kind = sizes.joint.output.kind
    what = f"the {kind} sweeps {depth:.1f} mm into the cylinder or the clamp of the hoses"
    raise DesignError(what, where=f"{sizes.design.label}.output", right=_mend(sizes))


def _sweep_depth(sizes: JointSizes) -> float:
    """Return how deep cam or roller sweeps into cylinder or clamp bars, mm; 0 if it turns freely."""
    section = CrossSection(sizes)
    clamp = section.cam_clamp().points()
    normal = clamp - clamp.mean(axis=0)
    points = np.vstack((cam_loop(sizes).points(), clamp + normal / np.hypot(*normal.T)[:, None] * HEAD_HEIGHT / 2))
    depth = 0.0
    for angle in np.linspace(-sizes.swing, sizes.swing, POSE_COUNT):
        turn = sizes.stroke / 2 + float(angle)
        c, s = np.cos(turn), np.sin(turn)
        placed = points @ np.array([[c, s], [-s, c]]) + [0.0, sizes.axis]
        depth = max(depth, _depth(sizes, section, placed))
    return depth


def _depth(sizes: JointSizes, section: CrossSection, points: Array) -> float:
    """Return how deep points (n, 2) lie in cylinder, or clamp bars, with the clearance around them, mm."""
    radius, angle = np.hypot(*points.T), np.mod(np.arctan2(points[:, 1], points[:, 0]) + np.pi / 2, 2 * np.pi)
    edge = section.window_end + np.pi / 2 - 2 * np.pi  # of the window on the side of hose A, from the clamp on
    beside = (angle < -edge) | (angle > 2 * np.pi + edge)
    into = np.where(beside, radius - sizes.inner_radius + sizes.clearance / 2, 0.0)
    x, y, depth = bar_place(sizes)
    reach = x + sizes.clamp_bar / 2 + sizes.screw.head_height * MM
    above = y + depth / 2 + sizes.clearance / 2 - points[:, 1]
    bars = np.where(np.abs(points[:, 0]) < reach, above, 0.0)
    return float(max(0.0, into.max(), bars.max()))


def _mend(sizes: JointSizes) -> str:
    """Return which offset of the output's axis would mend it, or what else."""
    joint, name = sizes.joint, sizes.design.name
    machine = sizes.design.machine
    offset = joint.output.shaft_offset
    while offset + OFFSET_STEP < joint.cylinder.diameter / 2:
        offset += OFFSET_STEP
        output = joint.output.model_copy(update={"shaft_offset": offset})
        changed = machine.model_copy(
            update={"joint": {**machine.joint, name: joint.model_copy(update={"output": output})}}
        )
        try:
            if _sweep_depth(replace(sizes, design=design_joint(changed, name))) <= 0.0:
                return f"give output.shaft_offset of {offset * MM:.0f} mm"
        except LayflatError:
            continue
    return "a longer stroke or a wider cylinder leaves room"
