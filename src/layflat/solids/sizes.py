"""Sizes of the parts of one joint, from its description and rules, in mm.

The frame is that of the strap's line (design/straplines.py): the cylinder's axis is z, the hoses are clamped at -y, and
the output's axis lies at +y. Along z, 0 is the middle of the hoses; the brake is below, the angle sensor above.

Along z, from the middle out: the cam of hose A, half a cam of hose B, the arm plate, the end plate. The strap of hose B
is as wide as that of A but in two strips beside it, so that no strap tilts the output.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import cbrt, cos, pi, sin, sqrt
from typing import TYPE_CHECKING

from layflat.design.straplines import ShellLine, direction_vector, joint_strap_line
from layflat.design.strength import SHAFT_YIELD
from layflat.errors import DesignError
from layflat.lazy import numpy as np
from layflat.machine.build_sizes import Build
from layflat.machine.parts import CLAMPED_LENGTH
from layflat.solids.standard.bushes import BUSHES, Bush, bush
from layflat.solids.standard.materials import MATERIALS
from layflat.solids.standard.screws import nut
from layflat.solids.standard.stock import next_thickness
from layflat.solids.standard.threads import THREADS, Thread, thread

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.design import JointDesign
    from layflat.machine import Joint

MM = 1e3  # mm per metre
RUBBER_DENSITY = 1150.0  # of a woven hose with its lining, kg/m3
SPACER_THICKNESS = 1.0  # thickness of the washers between cams and arm plates, mm
TAIL_SHARE = 0.5  # most that a hose's clamp takes of the cylinder's inner radius
RIM_WIDTH = 2.0  # of an end plate beyond the shells, mm
RING_WIDTH = 2.5  # least width of the cylinder's rings beside its window, mm
SHAFT_SAFETY = 2.0  # required yield over bending stress of the shaft beside a bush: its load comes and goes
PLATE_SAFETY = 3.0  # required yield over bending stress of arm plates and clamp bars
ARM_WALL = 1.5  # wall of an arm plate beside its bore over the diameter of the frame's screws
LEAST_PLATE = 0.004  # thickness of a plate, m
BAR_SHARE = 2.2  # least thickness of a clamp bar over the diameter of the screws in its ends
CLAMP_PITCH = 40.0  # between screws of the clamp, mm
PLATE_SHARE = 0.09  # least thickness of an end plate over the cylinder's diameter, by the mass of the paper's joints
ROD_SIDES = ((1, -1), (-1,))  # sides of the shaft with a rod, in the order of preference
LUG_SHARE, LEAST_LUG = 0.4, 1.5  # wall around a rod over its diameter, and at least, mm
BORE_WALL = 1.5  # between bore and rod, mm
NUT_GAP = 0.3  # between a rod's nut and the shaft, mm
NOSE_STRESS_SHARE = 0.55  # share of the strap's yield stress that bending over the shell's nose may take
DISC_HUB = 5.0  # height of the hub of the brake's disc, mm
PAD_THICKNESS = 2.0  # thickness of a brake pad, mm
SCREW_SIZES = ((45.0, "M2.5"), (70.0, "M3"), (85.0, "M4"), (120.0, "M5"), (200.0, "M6"), (float("inf"), "M8"))
"""Screws of a frame by cylinder diameter: up to a diameter (mm), a size."""


kept_by_sizes = lru_cache(maxsize=16)
"""Decorator of functions of `JointSizes` that are asked at many angles of a joint."""


@dataclass(frozen=True, eq=False)
class JointSizes:
    """Sizes of the parts of a joint, mm; raises DesignError where no size keeps a rule.

    What is made of them at all angles is kept for each object (`kept_by_sizes`).
    """

    design: JointDesign
    mount: float | None = None  # direction of the end plates' tongues, by which a link carries the joint, rad
    foot: bool = False  # whether the joint stands on a foot

    @property
    def joint(self) -> Joint:
        """The described joint."""
        return self.design.joint

    @property
    def build(self) -> Build:
        """Description of how it is built."""
        return self.joint.build or Build()

    @property
    def label(self) -> str:
        """File, joint and table, for messages."""
        return f"{self.design.label}.build"

    @property
    def double(self) -> bool:
        """True with two hoses."""
        return self.joint.acting == "double"

    @property
    def radius(self) -> float:
        """Outer radius of the cylinder."""
        return self.joint.cylinder.diameter / 2 * MM

    @property
    def inner_radius(self) -> float:
        """Inner radius of the cylinder."""
        return self.radius - self.joint.cylinder.wall * MM

    @property
    def clearance(self) -> float:
        """Least distance between parts that move past each other."""
        return self.build.clearance * MM

    @property
    def hose_wall(self) -> float:
        """Thickness of one layer of hose."""
        wall = self.build.hose_wall
        return (self.joint.hose.areal_mass / RUBBER_DENSITY if wall is None else wall) * MM

    @property
    def hose_layers(self) -> int:
        """Number of layers of the collapsed hose, one on another."""
        return 4 if self.joint.hose.folded else 2

    @property
    def hose_thickness(self) -> float:
        """Thickness of the collapsed hose."""
        return self.hose_layers * self.hose_wall

    @property
    def hose_width(self) -> float:
        """Width of the flat hose."""
        return self.joint.hose.width * MM

    @property
    def shell(self) -> float:
        """Thickness of the outer shell."""
        return self.joint.cover.thickness * MM

    @property
    def tail(self) -> float:
        """Length of hose in the clamp: that of `part_masses`, or as much as a small cylinder takes."""
        return min(CLAMPED_LENGTH * MM, TAIL_SHARE * self.inner_radius)

    @property
    def strap_width(self) -> float:
        """Width of a hose's strap: of hose B, that of both strips together."""
        return self.joint.strap.width * MM

    @property
    def strap_thickness(self) -> float:
        """Thickness of a strap's layers together."""
        return self.joint.strap.thickness * self.joint.strap.layers * MM

    @cached_property
    def line(self) -> ShellLine:
        """Line of the strap from shell to output; raises DesignError if a roller deflects it."""
        line = joint_strap_line(self.joint)
        if not isinstance(line, ShellLine):
            right = "give output.shaft_offset, and no deflecting_roller, for a strap straight from shell to output"
            raise DesignError("no solids of a joint whose strap is deflected", where=self.design.label, right=right)
        return line

    @property
    def axis(self) -> float:
        """Distance of the output's axis from the cylinder's, along y."""
        return self.line.axis[1] * MM

    @property
    def stroke(self) -> float:
        """Stroke of cam or roller from the collapsed hose to its full travel, rad."""
        return self.design.stroke if self.design.cam is None else self.design.cam.stroke

    @property
    def swing(self) -> float:
        """Angle from mid-stroke to the mechanical limit, rad."""
        return self.joint.stops.mechanical_stroke / 2

    @property
    def torque(self) -> float:
        """Greatest torque, N m."""
        return float(self.design.torque[1].max())

    @property
    def pull(self) -> float:
        """Greatest tension of a strap, N."""
        return float(self.design.tension.max())

    @property
    def nose_radius(self) -> float:
        """Radius over which the strap leaves the shell."""
        strap = self.joint.strap
        fibre = strap.fibre or strap.thickness
        return max(1.0, strap.modulus * fibre / (2 * NOSE_STRESS_SHARE * strap.yield_stress) * MM)

    @cached_property
    def screw(self) -> Thread:
        """Size of the frame's screws."""
        if self.build.screw is not None:
            return thread(self.build.screw, f"{self.label}.screw")
        return THREADS[next(name for limit, name in SCREW_SIZES if 2 * self.radius <= limit)]

    @cached_property
    def rod(self) -> Thread:
        """Size of the rods through the output's cams: the largest, up to the frame's screws, whose lugs fit inside."""
        return self._rods[0]

    @property
    def rod_sides(self) -> tuple[int, ...]:
        """Sides of the shaft, along y, on which the cams have a rod: both, or in small cams that away from the arm."""
        return self._rods[1]

    @cached_property
    def _rods(self) -> tuple[Thread, tuple[int, ...]]:
        least = self._least_rod.diameter
        for sides in ROD_SIDES:
            for size in reversed(THREADS.values()):
                if least <= size.diameter <= self.screw.diameter and self._lug_room(size, sides) >= 0.0:
                    return size, sides
        inside = f"inside the {self.joint.output.kind}s"
        what = f"no rod of M{least * MM:g} or more fits beside a shaft of {self.shaft:g} mm {inside}"
        raise DesignError(what, where=f"{self.design.label}.output", right="a shorter stroke makes wider cams")

    @property
    def _least_rod(self) -> Thread:
        """Return the smallest size of a rod: M3, or the frame's screws if they are smaller."""
        return min(THREADS["M3"], self.screw, key=lambda one: one.diameter)

    @property
    def rod_points(self) -> Array:
        """Places of the rods in a cam's own frame, (n, 2), on the line of the arm at mid-stroke."""
        return self._rod_points(*self._rods)

    def _rod_points(self, size: Thread, sides: tuple[int, ...]) -> Array:
        r, angle = self.rod_distance(size), -self.stroke / 2
        points: Array = np.array([[-side * r * sin(angle), side * r * cos(angle)] for side in sides])
        return points

    def _lug_room(self, size: Thread, sides: tuple[int, ...]) -> float:
        """Return the least distance from lugs around rods to the lines of the strap; below 0 one crosses."""
        lug, cam = self.lug_radius(size), self.design.cam
        if cam is None:
            return self.joint.output.radius * MM - self.rod_distance(size) - lug
        across = self._rod_points(size, sides) @ direction_vector(cam.normal).T
        return float((cam.lever * MM - across).min()) - lug

    def rod_distance(self, size: Thread) -> float:
        """Return the distance of the rods of a size from the output's axis: bore and nut leave room between."""
        room = max(BORE_WALL + size.clearance_hole * MM / 2, size.nut_flats * MM / 2 + NUT_GAP)
        return self.shaft / 2 + room

    def lug_radius(self, size: Thread) -> float:
        """Return the radius of the lug around a rod of a size."""
        return size.clearance_hole * MM / 2 + max(LUG_SHARE * size.diameter * MM, LEAST_LUG)

    @property
    def arm_width(self) -> float:
        """Width of an arm plate: the shaft's bore, and a wall of one and a half screws on either side."""
        return self.shaft + 2 * ARM_WALL * self.screw.diameter * MM

    @cached_property
    def arm_plate(self) -> float:
        """Thickness of an arm plate: two of them bear the torque in bending beside the bore."""
        given = self.build.arm_plate_thickness
        if given is not None:
            return given * MM
        net = 2 * ARM_WALL * self.screw.diameter
        section = self.torque / 2 * PLATE_SAFETY / MATERIALS["aluminium"].yield_stress
        return next_thickness(max(6 * section / net**2, LEAST_PLATE)) * MM

    @cached_property
    def end_plate(self) -> float:
        """Thickness of an end plate."""
        given = self.build.end_plate_thickness
        if given is not None:
            return given * MM
        return next_thickness(max(PLATE_SHARE * 2 * self.radius / MM, LEAST_PLATE)) * MM

    @property
    def cam_b(self) -> tuple[float, float]:
        """Ends of the upper half of the cam of hose B along z."""
        low = self.strap_width / 2 + SPACER_THICKNESS
        return (low, low + self.strap_width / 2) if self.double else (self.strap_width / 2, self.strap_width / 2)

    @property
    def arm_z(self) -> tuple[float, float]:
        """Ends of the upper arm plate along z."""
        low = self.cam_b[1] + SPACER_THICKNESS
        return low, low + self.arm_plate

    @property
    def window(self) -> float:
        """Half of the length of the cylinder's window: shells, arm plates and their nuts move in it."""
        nuts = self.arm_z[1] + (nut(self.screw.name, thin=True).height + self.screw.pitch) * MM
        return max(self.hose_width / 2, nuts) + self.clearance

    @property
    def half_length(self) -> float:
        """Half of the cylinder's length, with a ring beside the window."""
        return self.window + RING_WIDTH

    @property
    def rim(self) -> float:
        """Radius of an end plate about the cylinder's axis: it covers the collapsed hoses and their shells."""
        return self.radius + self.hose_thickness + self.shell + RIM_WIDTH

    @property
    def top(self) -> float:
        """Outer face of the upper end plate along z; that of the lower one is below by as much."""
        return self.half_length + self.end_plate

    @cached_property
    def bush(self) -> Bush:
        """Bush in the end plates: the smallest whose shaft bears half of a strap's greatest pull beside it."""
        given = self.build.shaft_diameter
        if given is not None:
            return bush(given, f"{self.label}.shaft_diameter")
        lever = (self.top - self.end_plate / 2 - self.arm_z[1]) / MM
        bends = cbrt(32 * self.pull / 2 * lever / (pi * SHAFT_YIELD / SHAFT_SAFETY))
        for one in BUSHES:
            if one.bore >= bends and one.allowed_load(self.end_plate / MM) >= self.pull / 2:
                return one
        if BUSHES[-1].bore >= bends:
            what = f"bushes in end plates of {self.end_plate:g} mm do not bear a pull of {self.pull:.0f} N"
            raise DesignError(what, where=self.label, right="thicker end plates bear more")
        what = f"no shaft of up to {BUSHES[-1].bore * MM:g} mm bears a pull of {self.pull:.0f} N"
        raise DesignError(what, where=self.label, right="a lower supply pressure pulls less")

    @property
    def shaft(self) -> float:
        """Diameter of the shaft."""
        return self.bush.bore * MM

    @cached_property
    def clamp_bar(self) -> float:
        """Thickness of a bar that clamps the hoses: it bears their pull, bent between the screws."""
        given = self.build.clamp_bar_thickness
        if given is not None:
            return given * MM
        pitch = self.hose_width / (self.clamp_screws - 1) / MM
        moment = self.pull / self.hose_width * MM * pitch**2 / 8
        allowed = MATERIALS["aluminium"].yield_stress / PLATE_SAFETY
        return next_thickness(max(sqrt(6 * moment / (allowed * self.tail / MM)), self.least_clamp_bar / MM)) * MM

    @property
    def least_clamp_bar(self) -> float:
        """Least thickness of a bar into whose ends the end plates are screwed."""
        return BAR_SHARE * self.screw.diameter * MM

    @property
    def clamp_screws(self) -> int:
        """Number of screws through the bars."""
        return max(2, round(self.hose_width / CLAMP_PITCH) + 1)

    @property
    def disc(self) -> float:
        """Thickness of the brake's disc."""
        return self.build.disc_thickness * MM

    @property
    def disc_hub(self) -> float:
        """Height of the disc's hub."""
        return DISC_HUB
