"""The inlets of air: stems in the hoses' inner walls that pass through the cylinder, with elbows inside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import atan2, cos, pi, radians, sin, sqrt
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import stepped
from layflat.solids.places import bar_place, clamp_heights, tie_places, tie_radius
from layflat.solids.section import CONTACT_GAP, HINGE_GAP, LAP_LENGTH
from layflat.solids.shapes import Drilled, Turned, place
from layflat.solids.sizes import MM, kept_by_sizes
from layflat.solids.standard.fittings import TUBE_SIZES, HollowScrew, PushInFitting, push_in_fitting
from layflat.solids.tubing import hose_tube

if TYPE_CHECKING:
    from layflat.solids.component import Group
    from layflat.solids.section import CrossSection
    from layflat.solids.sizes import JointSizes

INLET_ANGLES = tuple(radians(float(a)) for a in range(-170, -115, 1))  # on the cylinder, of hose A
LEAST_ROOM = 0.25  # between an inlet and what lies beside it, mm
SEAT_GAP = 0.15  # between a flat nut and a round shell, mm
HOLE_GAP = 0.2  # between a stem and its hole, mm
ELBOW_LENGTH = 3e-3  # length of an elbow beyond its tube's diameter, m


@dataclass(frozen=True)
class Inlet:
    """Inlet of hose A: a stem with a nut inside the cylinder, and an elbow or a barb behind it, mm."""

    designation: str
    stem: float  # diameter of the stem
    nut: float  # length of the nut
    flange: float  # diameter of the nut
    end: float  # length of elbow or barb
    body: float  # diameter of elbow or barb
    bore: float  # of its tube, m
    mass: float  # kg
    angle: float = 0.0  # on the cylinder, rad
    outside: bool = False  # whether it passes through the shell instead of the cylinder

    @property
    def reach(self) -> float:
        """Length inside the cylinder."""
        return self.nut + self.end


def _push_in(fitting: PushInFitting) -> Inlet:
    """Return an inlet with an elbow for push-in tubing."""
    port, outer = fitting.port, fitting.tube_outer
    mass = HollowScrew(port, 2e-3).mass + fitting.mass
    name = f"stem {port.name} with flange in the hose, nut, elbow push-in {port.name} - {outer * MM:g}"
    flange, end = port.flange * MM, (outer + ELBOW_LENGTH) * MM
    return Inlet(name, port.diameter * MM, port.depth * MM, flange, end, fitting.body_diameter * MM,
                 fitting.tube_inner, mass)  # fmt: skip


SMALL_INLET = Inlet(
    "stem M4 with flange in the hose, nut ISO 4035 M4, barb for tubing 4 x 2.5",
    stem=4.0, nut=2.2, flange=8.1, end=5.0, body=4.0, bore=1.8e-3, mass=2.5e-3,
)  # fmt: skip
"""Inlet of small cylinders."""


@kept_by_sizes
def choose_inlet(sizes: JointSizes) -> Inlet:
    """Return the inlet that is as wide as its tube, or else the widest that fits between clamp bars and tie bars.

    In the smallest cylinders none fits: there the inlet sits outside, in the shell.
    """
    wanted, *_ = hose_tube(sizes.design.machine, sizes.design.name)
    inlets = [_push_in(push_in_fitting(name, outer)) for name, tubes in TUBE_SIZES.items() for outer, _ in tubes]
    narrow = [inlet for inlet in (SMALL_INLET, *inlets) if inlet.bore < wanted - 1e-9]
    wide = [inlet for inlet in inlets if inlet.bore >= wanted - 1e-9]
    for inlet in (*wide, *reversed(narrow)):
        room, angle = max((_room(sizes, inlet, angle), angle) for angle in INLET_ANGLES)
        if room >= LEAST_ROOM:
            return replace(inlet, angle=angle)
    return replace(SMALL_INLET, outside=True)


def _room(sizes: JointSizes, inlet: Inlet, angle: float) -> float:
    """Return the least distance of an inlet at an angle (rad) from tie bar and clamp bar, mm; below 0 they overlap."""
    reach = inlet.reach
    line = np.linspace(sizes.inner_radius - reach, sizes.inner_radius, 20)[:, None] * [[cos(angle), sin(angle)]]
    tie = np.hypot(*(line - tie_places(sizes)[0]).T).min() - tie_radius(sizes)
    x, y, depth = bar_place(sizes)
    beyond = np.maximum(np.abs(line - [-x, y]) - [sizes.clamp_bar / 2, depth / 2], 0.0)
    return float(min(tie, np.hypot(*beyond.T).min())) - max(inlet.body, inlet.flange) / 2


def inlet_holes(sizes: JointSizes) -> tuple[Drilled, ...]:
    """Return the holes of the inlets in the cylinder, in its own frame."""
    chosen = choose_inlet(sizes)
    if chosen.outside:
        return ()
    R = sizes.radius + 1.0
    found = []
    for s, z in _sides(sizes):
        x, y = s * cos(chosen.angle), sin(chosen.angle)
        diameter = chosen.stem + 2 * HOLE_GAP
        start = (R * x, R * y, sizes.half_length + z)
        found.append(Drilled(start, (-x, -y, 0.0), diameter, R - 0.8 * sizes.inner_radius))
    return tuple(found)


def _sides(sizes: JointSizes) -> list[tuple[float, float]]:
    """Return the side of each inlet, 1 for that of hose A, and its height between two screws of the clamp, mm."""
    heights = clamp_heights(sizes)
    z = (heights[-1] + heights[-2]) / 2
    return [(1.0, z), (-1.0, -z)][: 2 if sizes.double else 1]


def inlet(sizes: JointSizes, group: Group) -> Component:
    """Return the inlet of hose A, in its frame, with the group that it moves with."""
    chosen = choose_inlet(sizes)
    (_, z), *_ = _sides(sizes)
    seat = sqrt(sizes.inner_radius**2 - (chosen.flange / 2) ** 2) - 0.02  # the nut's rim meets the cylinder
    stem = sqrt((sizes.radius + CONTACT_GAP) ** 2 - (chosen.stem / 2) ** 2) - seat  # its rim meets the hose
    outline = stepped(
        (chosen.body / 2, 0.0, chosen.end),
        (chosen.flange / 2, chosen.end, chosen.reach),
        (chosen.stem / 2, chosen.reach, chosen.reach + stem),
    )
    x, y = cos(chosen.angle), sin(chosen.angle)
    distance = seat - chosen.reach
    return Component(
        f"inlet of hose {group[-1].upper()}", "body", Turned(outline), "brass", "bought",
        (place(distance * x, distance * y, z, axes_towards(x, y, 0.0)),), chosen.designation, chosen.mass,
    )  # fmt: skip


def outer_inlet(sizes: JointSizes, section: CrossSection, group: Group) -> tuple[Component, Drilled]:
    """Return the inlet of hose A through its shell, with the collapsed hose, and its hole in the shell.

    Args:
        sizes: sizes of the joint.
        section: its cross-section.
        group: of the shell.
    """
    chosen, shell = choose_inlet(sizes), sizes.radius + sizes.hose_thickness
    (x, y), z = section.ramp[0], sizes.hose_width / 4
    outer = shell + sizes.shell
    lap = -pi / 2 - (HINGE_GAP + LAP_LENGTH) / outer
    angle = (lap + atan2(y, x) - 2 * pi * (y > 0)) / 2
    x, y = cos(angle), sin(angle)
    low = CONTACT_GAP
    outline = stepped(
        (chosen.stem / 2, low, sizes.shell + SEAT_GAP),
        (chosen.flange / 2, sizes.shell + SEAT_GAP, sizes.shell + chosen.nut),
        (chosen.body / 2, sizes.shell + chosen.nut, sizes.shell + chosen.reach),
    )
    part = Component(
        f"outer inlet of hose {group[-1].upper()}", group, Turned(outline), "brass", "bought",
        (place(shell * x, shell * y, z, axes_towards(x, y, 0.0)),), chosen.designation, chosen.mass,
    )  # fmt: skip
    start = ((outer + 1.0) * x, (outer + 1.0) * y, z + sizes.hose_width / 2)
    return part, Drilled(start, (-x, -y, 0.0), chosen.stem + 2 * HOLE_GAP, sizes.shell + 2.0)
