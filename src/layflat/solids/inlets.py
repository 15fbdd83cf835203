"""The inlets of air: stems in the hoses' inner walls that pass through the cylinder, with elbows inside it."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin, sqrt
from typing import TYPE_CHECKING

from layflat.errors import DesignError
from layflat.lazy import numpy as np
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import stepped
from layflat.solids.places import TIE_SHARE, bar_place, clamp_heights, tie_places
from layflat.solids.section import CONTACT_GAP
from layflat.solids.shapes import Drilled, Turned, place
from layflat.solids.sizes import MM
from layflat.solids.standard.fittings import TUBE_SIZES, HollowScrew, PushInFitting, push_in_fitting

if TYPE_CHECKING:
    from layflat.solids.component import Group
    from layflat.solids.sizes import JointSizes

INLET_ANGLES = tuple(radians(float(a)) for a in range(-170, -115, 1))  # on the cylinder, of hose A
LEAST_ROOM = 0.5  # between an inlet and what lies beside it, mm
HOLE_GAP = 0.2  # between a stem and its hole, mm
DEFAULT_BORE = {False: 2.5e-3, True: 4e-3}  # of a tube where no line is described, m: hose below or above 60 mm wide
WIDE_HOSE = 60.0  # mm
ELBOW_LENGTH = 3e-3  # length of an elbow beyond its tube's diameter, m


def tube_bore(sizes: JointSizes) -> float:
    """Return the bore of the tube to a hose, m: the described line's, or one by the hose's width."""
    line = sizes.joint.line or sizes.design.machine.line
    return line.bore if line is not None else DEFAULT_BORE[sizes.hose_width > WIDE_HOSE]


@dataclass(frozen=True)
class Inlet:
    """Inlet of hose A: its fitting, and where it goes through the cylinder."""

    fitting: PushInFitting
    angle: float  # on the cylinder, rad

    @property
    def elbow(self) -> float:
        """Length of its elbow, mm."""
        return (self.fitting.tube_outer + ELBOW_LENGTH) * MM

    @property
    def reach(self) -> float:
        """Length inside the cylinder, mm."""
        return self.fitting.port.depth * MM + self.elbow


def choose_inlet(sizes: JointSizes) -> Inlet:
    """Return the inlet that is as wide as its tube, or else the widest that fits between clamp bars and tie bars.

    Raises:
        DesignError: none fits.
    """
    wanted = tube_bore(sizes)
    fittings = [push_in_fitting(name, outer) for name, tubes in TUBE_SIZES.items() for outer, _ in tubes]
    narrow = [one for one in fittings if one.tube_inner < wanted - 1e-9]
    wide = [one for one in fittings if one.tube_inner >= wanted - 1e-9]
    for fitting in (*wide, *reversed(narrow)):
        room, angle = max((_room(sizes, fitting, float(a)), float(a)) for a in INLET_ANGLES)
        if room >= LEAST_ROOM:
            return Inlet(fitting, angle)
    what = f"no inlet fits into a cylinder with an inner diameter of {2 * sizes.inner_radius:.4g} mm"
    raise DesignError(what, where=sizes.label, right="give a wider cylinder, or a smaller build.screw")


def _room(sizes: JointSizes, fitting: PushInFitting, angle: float) -> float:
    """Return the least distance of a fitting at an angle (rad) from tie bar and clamp bar, mm; below 0 they overlap."""
    radius = max(fitting.body_diameter, fitting.port.flange) * MM / 2
    reach = Inlet(fitting, angle).reach
    line = np.linspace(sizes.inner_radius - reach, sizes.inner_radius, 20)[:, None] * [[cos(angle), sin(angle)]]
    tie = np.hypot(*(line - tie_places(sizes)[0]).T).min() - TIE_SHARE * sizes.screw.diameter * MM / 2
    x, y, depth = bar_place(sizes)
    beyond = np.maximum(np.abs(line - [-x, y]) - [sizes.clamp_bar / 2, depth / 2], 0.0)
    return float(min(tie, np.hypot(*beyond.T).min())) - radius


def inlet_holes(sizes: JointSizes) -> tuple[Drilled, ...]:
    """Return the holes of the inlets in the cylinder, in its own frame."""
    chosen = choose_inlet(sizes)
    one, angle = chosen.fitting.port, chosen.angle
    R = sizes.radius + 1.0
    found = []
    for s, z in _sides(sizes):
        x, y = s * cos(angle), sin(angle)
        diameter = one.diameter * MM + 2 * HOLE_GAP
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
    fitting, one, outer = chosen.fitting, chosen.fitting.port, chosen.fitting.tube_outer
    (_, z), *_ = _sides(sizes)
    seat = sqrt(sizes.inner_radius**2 - (one.flange * MM / 2) ** 2) - 0.02  # the nut's rim meets the cylinder
    stem = sizes.radius + CONTACT_GAP - seat
    nut, elbow = one.depth * MM, chosen.elbow
    outline = stepped(
        (fitting.body_diameter * MM / 2, 0.0, elbow),
        (one.flange * MM / 2, elbow, elbow + nut),
        (one.diameter * MM / 2, elbow + nut, elbow + nut + stem),
    )
    x, y = cos(chosen.angle), sin(chosen.angle)
    distance = seat - elbow - nut
    screw = HollowScrew(one, stem / MM)
    return Component(
        f"inlet of hose {group[-1].upper()}", "body", Turned(outline), "brass", "bought",
        (place(distance * x, distance * y, z, axes_towards(x, y, 0.0)),),
        f"stem {one.name} with flange in the hose, nut, elbow push-in {one.name} - {outer * MM:g}",
        screw.mass + fitting.mass,
    )  # fmt: skip
