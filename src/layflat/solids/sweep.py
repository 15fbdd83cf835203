"""The check that the output turns freely inside its cylinder, before any solid is made."""

from __future__ import annotations

from typing import TYPE_CHECKING

from layflat.errors import DesignError
from layflat.lazy import numpy as np
from layflat.solids.cams import cam_loop
from layflat.solids.places import bar_place, tie_places, tie_radius
from layflat.solids.section import CrossSection
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.loops import Loop
    from layflat.solids.sizes import JointSizes

POSE_COUNT = 15  # of the output over its mechanical stroke
POINT_STEP = 1.0  # greatest distance of points of an outline, mm
PART_GAP = 0.3  # least distance of cam or roller from shells and tie bars, mm


def check_sweep(sizes: JointSizes) -> None:
    """Raise DesignError if cam or roller meets the frame."""
    depth = _sweep_depth(sizes)
    if depth <= 0.0:
        return
    kind = sizes.joint.output.kind
    what = f"the {kind} sweeps {depth:.1f} mm into the cylinder, its tie bars, the shells or the clamp of the hoses"
    raise DesignError(what, where=f"{sizes.design.label}.output", right="a longer stroke leaves room")


def _sweep_depth(sizes: JointSizes) -> float:
    """Return how deep cam or roller sweeps into cylinder or clamp bars, mm; 0 if it turns freely."""
    section = CrossSection(sizes)
    points = np.vstack([_outline(loop) for loop in (cam_loop(sizes), section.cam_clamp(), section.screw_head())])
    depth = 0.0
    for angle in np.linspace(-sizes.swing, sizes.swing, POSE_COUNT):
        turn = sizes.stroke / 2 + float(angle)
        c, s = np.cos(turn), np.sin(turn)
        placed = points @ np.array([[c, s], [-s, c]]) + [0.0, sizes.axis]
        depth = max(depth, _depth(sizes, section, placed))
        shells = [section.shell_corners(turn)]
        if sizes.double:
            shells.append(section.shell_corners(sizes.stroke - turn) * [-1.0, 1.0])
        depth = max(depth, *(PART_GAP - _distance(placed, shell) for shell in shells))
    return depth


def _distance(points: Array, corners: Array) -> float:
    """Return the least distance of points (n, 2) from the sides of a polygon of corners (m, 2) near them, mm."""
    near = np.hypot(*(corners - points.mean(axis=0)).T) < 2 * np.ptp(points, axis=0).max()
    start, side = corners[near], (np.roll(corners, -1, axis=0) - corners)[near]
    apart = points[:, None] - start
    share = np.clip(np.sum(apart * side, axis=-1) / np.sum(side * side, axis=-1), 0.0, 1.0)
    return float(np.hypot(*np.moveaxis(apart - share[..., None] * side, -1, 0)).min(initial=np.inf))


def _outline(loop: Loop) -> Array:
    """Return points of an outline, mm, (n, 2)."""
    corners = loop.points()
    sides = np.roll(corners, -1, axis=0) - corners
    counts = np.ceil(np.hypot(*sides.T) / POINT_STEP).astype(int)
    shares = [np.arange(count)[:, None] / count for count in counts]
    points: Array = np.vstack([a + share * side for a, share, side in zip(corners, shares, sides, strict=True)])
    return points


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
    radius = tie_radius(sizes) + PART_GAP
    ties = [radius - np.hypot(*(points - tie).T).min() for tie in tie_places(sizes)]
    return float(max(0.0, into.max(), bars.max(), *ties))
