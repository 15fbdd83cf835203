"""Cross-section of a joint at any angle of its output: shell, strap, hose and hinge of hose A.

Hose B is its mirror image.

All lengths are in mm, in the frame of `sizes.py`. Turns count from the collapsed hose on, in rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import asin, atan2, cos, hypot, pi, sin, sqrt
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.cams import CLAMP_SCREW, opening, winding
from layflat.solids.loops import ribbon, sector
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.loops import Loop, Point
    from layflat.solids.sizes import JointSizes

WEBBING_THICKNESS = 1.0  # thickness of the hinge's webbing
LAP_LENGTH = 20.0  # length of webbing on the shell
HINGE_GAP = 6.0  # from the plane of both hinges to the edge of the shell
FILM_THICKNESS = 0.02  # between a strap and what it lies on
CONTACT_GAP = 0.05  # between a hose and what it lies on
BAR_THICKNESS = 4.5  # thickness of the bar under the shell's end, into which the strap's screws go
STRIP_THICKNESS = 2.0  # thickness of the strip that clamps the strap
ARC_STEP = pi / 60  # between points of arcs, rad
STATION_COUNT = 16  # of a hose along its wrap
EDGE_POINTS = 7  # of a hose's rounded edge
BEYOND_ANGLE = 0.05  # angle by which the shell's nose goes on beyond its last contact, rad


@dataclass(frozen=True)
class CrossSection:
    """Cross-section of the parts of hose A, in the frame of the joint with the hose collapsed."""

    sizes: JointSizes

    @cached_property
    def start(self) -> Array:
        """Strap point with the hose collapsed, (2,)."""
        return np.array(self.sizes.line.start) * MM

    @cached_property
    def headings(self) -> Array:
        """Direction of the strap towards the output in the shell's own frame at each turn of the stroke, rad, (n,)."""
        sizes, cam = self.sizes, self.sizes.design.cam
        headings: Array
        if cam is not None:
            headings = np.unwrap(cam.line_normal) - pi / 2 - cam.travel / sizes.line.chord
            return headings
        turns = np.linspace(0.0, sizes.stroke, 41)
        feet = [self.foot(float(turn)) - self._moved(self.start, float(turn)) for turn in turns]
        headings = np.unwrap([atan2(y, x) for x, y in feet])
        headings -= np.array([opening(sizes, float(turn)) for turn in turns])
        return headings

    @cached_property
    def nose(self) -> tuple[Array, float, float]:
        """Centre of the shell's nose, (2,), and the greatest and least heading of the strap on it, rad."""
        high, low = float(self.headings.max()), float(self.headings.min())
        middle = (high + low) / 2
        return self.start + self.sizes.nose_radius * _right(middle), high, low

    @property
    def strap_miss(self) -> float:
        """Greatest distance of the strap's line from the strap point over the stroke: the nose is round."""
        _, high, low = self.nose
        return self.sizes.nose_radius * (1 - cos((high - low) / 2))

    @cached_property
    def ramp(self) -> tuple[Array, Array]:
        """Ends of the straight end of the shell's outer face, on which the strap is clamped, (2,) each."""
        centre, high, _ = self.nose
        end = centre - self.sizes.nose_radius * _right(high)
        along = np.array([cos(high), sin(high)])
        outer = self.sizes.radius + self.sizes.hose_thickness + self.sizes.shell
        b = float(end @ along)
        length = b + sqrt(max(b * b - float(end @ end) + outer * outer, 0.0))
        return end - length * along, end

    @cached_property
    def outer_face(self) -> Array:
        """Outer face of the shell from its hinge to beyond its nose, (n, 2)."""
        sizes = self.sizes
        outer = sizes.radius + sizes.hose_thickness + sizes.shell
        (x, y), (centre, high, low) = self.ramp[0], self.nose
        first, last = -pi / 2 - asin(HINGE_GAP / outer), atan2(y, x) - 2 * pi * (y > 0)
        arc = outer * _directions(first, last)
        curl = [centre - sizes.nose_radius * _right(a) for a in _angles(high, low - BEYOND_ANGLE)]
        return np.vstack((arc, curl))

    def shell(self) -> Loop:
        """Return the shell."""
        return ribbon(self.outer_face, self.sizes.shell, 0.0)

    def _on_ramp(self, first: float, last: float, below: float, above: float) -> Loop:
        """Return a strip along the ramp: from and to shares of its length, between distances from its face."""
        start, end = self.ramp
        return ribbon(np.vstack((start + first * (end - start), start + last * (end - start))), below, above)

    def bar(self) -> Loop:
        """Return the bar under the ramp, into which the strap's screws go."""
        return self._on_ramp(0.12, 1.0, self.sizes.shell + BAR_THICKNESS, -self.sizes.shell)

    def shell_corners(self, turn: float) -> Array:
        """Return the corners of the shell after a turn, (n, 2)."""
        return self._moved(self.shell().points(), turn)

    def clamp_strip(self) -> Loop:
        """Return the strip that clamps the strap on the ramp."""
        below = self.sizes.strap_thickness + 2 * FILM_THICKNESS
        return self._on_ramp(0.05, 0.95, -below, below + STRIP_THICKNESS)

    @cached_property
    def hose_end(self) -> float:
        """Angle on the cylinder at which the collapsed hose ends, before the bar, rad, from -pi/2 down."""
        corners = self.bar().points()
        last = max(float(angle) for angle in np.unwrap([atan2(y, x) for x, y in corners]))
        reach = (BAR_THICKNESS + 1.0) / self.sizes.radius  # the bar swings into the hose as the shell opens
        return last - 2 * pi * (last > 0) + reach

    @property
    def window_end(self) -> float:
        """Angle at which the cylinder's window begins, rad, of the side of hose A: the bar dips into it."""
        return self.hose_end + 2 * pi

    def _moved(self, points: Array, turn: float) -> Array:
        """Return points (..., 2) of the shell's frame where the shell is after a turn."""
        angle, hinge = opening(self.sizes, turn), np.array(self.sizes.line.hinge) * MM
        c, s = cos(angle), sin(angle)
        moved: Array = hinge + (points - hinge) @ np.array([[c, s], [-s, c]])
        return moved

    def foot(self, turn: float) -> Array:
        """Return the point at which the strap leaves cam or roller, (2,)."""
        point: Array = self._wound(turn)[0]
        return point

    def _wound(self, turn: float) -> Array:
        """Return the part of the strap that lies on cam or roller, in the joint's frame, from its foot on, (n, 2)."""
        sizes = self.sizes
        line = winding(sizes)
        count = len(line) - 1
        angles = np.linspace(0.0, sizes.stroke, count) if sizes.design.cam is None else sizes.design.cam.angle
        inside = min(max(turn, 0.0), sizes.stroke)
        foot = [float(np.interp(inside, angles, line[:count, k])) for k in (0, 1)]
        rest = line[int(np.searchsorted(angles, inside + 1e-9)) :]
        points = np.vstack((foot, rest)) if len(rest) else np.array([foot])
        if sizes.design.cam is None and turn < 0.0:  # a roller is round before its stroke, too
            first = atan2(foot[1], foot[0])
            points = np.vstack((hypot(*foot) * _directions(first - turn, first)[:-1], points))
        c, s = cos(turn), sin(turn)
        placed: Array = points @ np.array([[c, s], [-s, c]]) + np.array([0.0, sizes.axis])
        return placed

    def strap_path(self, turn: float) -> Array:
        """Return the line of the strap's inner face after a turn, from the ramp to the flat of the cam, (n, 2)."""
        wound = self._wound(turn)
        centre, high, low = self.nose
        leaves = float(np.interp(turn, np.linspace(0.0, self.sizes.stroke, len(self.headings)), self.headings))
        curl = [centre - self.sizes.nose_radius * _right(a) for a in _angles(high, max(min(leaves, high), low))]
        return _thinned(np.vstack((self._moved(np.vstack((self.ramp[0], *curl)), turn), wound)))

    def strap(self, turn: float) -> Loop:
        """Return the strap after a turn."""
        return ribbon(self.strap_path(turn), -FILM_THICKNESS, FILM_THICKNESS + self.sizes.strap_thickness)

    def cam_clamp(self) -> Loop:
        """Return the strip that clamps the strap on the flat of the cam, in the cam's own frame."""
        low = self.sizes.strap_thickness + 2 * FILM_THICKNESS
        return ribbon(winding(self.sizes)[-2:], -low, low + STRIP_THICKNESS)

    def screw_head(self) -> Loop:
        """Return the heads of the screws through that strip, in the cam's own frame."""
        ends = winding(self.sizes)[-2:]
        along = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0])) * CLAMP_SCREW.head_diameter / 2 * MM
        low = self.sizes.strap_thickness + 2 * FILM_THICKNESS + STRIP_THICKNESS
        return ribbon(ends.mean(axis=0) + np.vstack((-along, along)), -low, low + CLAMP_SCREW.head_height * MM)

    def webbing(self, turn: float) -> Loop:
        """Return the hinge's webbing after a turn: from the clamp to its lap on the shell."""
        sizes = self.sizes
        outer = sizes.radius + sizes.hose_thickness + sizes.shell
        first = -pi / 2 - asin(HINGE_GAP / outer)
        bend = first + WEBBING_THICKNESS / outer  # beyond the shell's edge, round which it does not go, then
        lap = self._moved(
            (outer + CONTACT_GAP + WEBBING_THICKNESS / 2) * _directions(bend, first - LAP_LENGTH / outer), turn
        )
        x = -WEBBING_THICKNESS / 2
        path = np.vstack(([x, -sizes.inner_radius + sizes.tail], [x, -sizes.radius - sizes.hose_thickness - 0.5], lap))
        return ribbon(path, WEBBING_THICKNESS / 2, WEBBING_THICKNESS / 2)

    def hose(self, turn: float) -> tuple[tuple[tuple[float, float, float], ...], ...]:
        """Return sections of the hose after a turn, from its clamped end on, with rounded edges as its law has them."""
        sizes = self.sizes
        h, R = sizes.hose_thickness, sizes.radius
        left, right = -WEBBING_THICKNESS - h + CONTACT_GAP, -WEBBING_THICKNESS - CONTACT_GAP
        pairs = [
            ((left, -sizes.inner_radius + sizes.tail), (right, -sizes.inner_radius + sizes.tail)),
            ((left, -R - CONTACT_GAP), (right, -R - CONTACT_GAP)),
            ((left, -R - CONTACT_GAP), (-WEBBING_THICKNESS - 0.4 * h, -R - 0.75 * h)),
        ]
        first = -pi / 2 - asin((WEBBING_THICKNESS + h) / R)
        stations = np.linspace(first, self.hose_end, STATION_COUNT)
        # Straight between stations, the hose would cut into the cylinder.
        R_out = (R + CONTACT_GAP) / cos((stations[0] - stations[1]) / 2)
        for angle in stations:
            inner = R_out * np.array([cos(angle), sin(angle)])
            outer = self._moved((R + h - CONTACT_GAP) * np.array([cos(angle), sin(angle)]), turn)
            pairs.append(((float(inner[0]), float(inner[1])), (float(outer[0]), float(outer[1]))))
        return tuple(_stadium(*pair, sizes.hose_width) for pair in pairs)


def window_loop(sizes: JointSizes, section: CrossSection) -> Loop:
    """Return the sector that the cylinder's window takes."""
    first = pi - section.window_end
    return sector(0.5 * sizes.inner_radius, 1.5 * sizes.radius, first, section.window_end)


def _stadium(inner: Point, outer: Point, width: float) -> tuple[tuple[float, float, float], ...]:
    """Return a section of a hose between two points: its flat width less what its rounded edges take."""
    gap = hypot(outer[0] - inner[0], outer[1] - inner[1])
    middle = ((inner[0] + outer[0]) / 2, (inner[1] + outer[1]) / 2)
    ex, ey = (outer[0] - inner[0]) / gap, (outer[1] - inner[1]) / gap
    half = max((width - pi / 2 * gap) / 2, 0.05 * width)
    upper = [(gap / 2 * cos(a), half + gap / 2 * sin(a)) for a in np.linspace(0.0, pi, EDGE_POINTS)]
    points = [*upper, *((-e, -z) for e, z in upper)]
    return tuple((middle[0] + e * ex, middle[1] + e * ey, float(z)) for e, z in points)


def _right(heading: float) -> Array:
    """Return the unit vector to the right of a heading (rad), (2,)."""
    return np.array([sin(heading), -cos(heading)])


def _angles(first: float, last: float) -> Array:
    return np.linspace(first, last, 2 + int(abs(last - first) / ARC_STEP))


def _directions(first: float, last: float) -> Array:
    angles = _angles(first, last)
    return np.stack((np.cos(angles), np.sin(angles)), axis=-1)


def _thinned(path: Array) -> Array:
    """Return a path without points that are closer than a tenth of a millimetre to the one before."""
    kept = [path[0]]
    for point in path[1:]:
        if np.hypot(*(point - kept[-1])) > 0.3:
            kept.append(point)
    return np.array(kept)
