"""The check that the output turns freely inside its cylinder, before any solid is made."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from layflat.design import design_joint
from layflat.errors import DesignError, LayflatError
from layflat.lazy import numpy as np
from layflat.solids.cams import cam_loop
from layflat.solids.places import bar_place, tie_places, tie_radius
from layflat.solids.section import CrossSection
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.machine.parts import OutputElement
    from layflat.solids.sizes import JointSizes

POSE_COUNT = 15  # of the output over its mechanical stroke
HEAD_HEIGHT = 4.0  # of the screws of the strap's clamp above the cam, mm
TIE_GAP = 0.3  # least distance of cam or roller from a tie bar of the frame, mm
OFFSET_STEP = 2e-3  # between output axes that are tried as a mend, m


def check_sweep(sizes: JointSizes) -> None:
    """Raise DesignError if cam or roller meets the frame; the message says what would mend it."""
    depth = _sweep_depth(sizes)
    if depth <= 0.0:
        return
    kind = sizes.joint.output.kind
    what = f"the {kind} sweeps {depth:.1f} mm into the cylinder, its tie bars or the clamp of the hoses"
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
    """Return how deep points (n, 2) lie in cylinder, tie bars or clamp bars, with the clearance around them, mm."""
    radius, angle = np.hypot(*points.T), np.mod(np.arctan2(points[:, 1], points[:, 0]) + np.pi / 2, 2 * np.pi)
    edge = section.window_end + np.pi / 2 - 2 * np.pi  # of the window on the side of hose A, from the clamp on
    beside = (angle < -edge) | (angle > 2 * np.pi + edge)
    into = np.where(beside, radius - sizes.inner_radius + sizes.clearance / 2, 0.0)
    x, y, depth = bar_place(sizes)
    reach = x + sizes.clamp_bar / 2 + sizes.screw.head_height * MM
    above = y + depth / 2 + sizes.clearance / 2 - points[:, 1]
    bars = np.where(np.abs(points[:, 0]) < reach, above, 0.0)
    radius = tie_radius(sizes) + TIE_GAP
    ties = [radius - np.hypot(*(points - tie).T).min() for tie in tie_places(sizes)]
    return float(max(0.0, into.max(), bars.max(), *ties))


def _mend(sizes: JointSizes) -> str:
    """Return which offset of the output's axis would mend it, or a roller, or what else."""
    output = sizes.joint.output
    room = sizes.joint.cylinder.diameter / 2 - output.shaft_offset
    for offset in output.shaft_offset + np.arange(OFFSET_STEP, room, OFFSET_STEP):
        if _turns_freely(sizes, output.model_copy(update={"shaft_offset": float(offset)})):
            return f"give output.shaft_offset of {offset * MM:.0f} mm"
    if output.kind == "cam" and _turns_freely(sizes, output.model_copy(update={"kind": "roller"})):
        return 'give output.kind of "roller", or a longer stroke'
    return "a longer stroke or a wider cylinder leaves room"


def _turns_freely(sizes: JointSizes, output: OutputElement) -> bool:
    """Return whether a joint with another output can be designed and its output turns freely."""
    machine, name = sizes.design.machine, sizes.design.name
    joint = sizes.joint.model_copy(update={"output": output})
    changed = machine.model_copy(update={"joint": {**machine.joint, name: joint}})
    try:
        return _sweep_depth(replace(sizes, design=design_joint(changed, name))) <= 0.0
    except LayflatError:
        return False
