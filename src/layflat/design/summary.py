"""A joint's whole design from its description: curve, cam, strap, findings of the design rules, mass and air."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import degrees, pi
from typing import TYPE_CHECKING, Literal

import numpy as np

from layflat.arrays import Array
from layflat.design.cam import Cam, Outline
from layflat.design.characteristic import Characteristic
from layflat.design.strength import StrapStress, shaft_advice, strap_stress
from layflat.errors import DesignError
from layflat.machine import Joint, Machine
from layflat.machine.parts import part_masses
from layflat.physics.air import GAS_CONSTANT, NORMAL_DENSITY
from layflat.plot.tables import html_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Severity = Literal["error", "warning", "note"]
SEVERITY_ORDER: tuple[Severity, ...] = ("error", "warning", "note")


@dataclass(frozen=True)
class Finding:
    """Finding of a design rule."""

    severity: Severity  # "error", "warning" or "note"
    rule: str  # short name of the rule
    where: str  # machine, joint and key
    what: str  # observation, with its value
    right: str = ""  # advice or consequence

    def __str__(self) -> str:
        text = f"{self.where}: {self.what}"
        return f"{text}; {self.right}" if self.right else text


def refuse_errors(findings: Sequence[Finding]) -> None:
    """Raise DesignError with the text of the first error among findings, if there is one."""
    for finding in findings:
        if finding.severity == "error":
            raise DesignError(finding.what, where=finding.where, right=finding.right)


@dataclass(frozen=True)
class JointMass:
    """Masses of the parts whose sizes the description gives, kg, and of the whole joint as described."""

    parts: dict[str, float]
    body: float

    @property
    def counted(self) -> float:
        """Sum of the parts, kg."""
        return sum(self.parts.values())

    @property
    def uncounted(self) -> float:
        """Mass of end plates, shaft, bearings, brake and fittings: the whole less the counted parts, kg."""
        return self.body - self.counted


@dataclass(frozen=True)
class AirConsumption:
    """Air of one full stroke of one hose from its collapsed state, at supply pressure."""

    swept_volume: float  # m3
    dead_volume: float  # m3
    normal_litres: float  # from the supply, at 0 degC and 1.01325 bar; isothermal at the supply's temperature


@dataclass(frozen=True)
class JointDesign:
    """Design of one joint."""

    machine: Machine  # to which it belongs
    name: str  # of the joint in the machine
    pressure: float  # gauge supply pressure, Pa; all torques, tensions and stresses hold at this pressure
    characteristic: Characteristic  # force of one hose over its travel
    cam: Cam | None  # the exact cam; None with a round roller
    outline: Outline | None  # the cam as a part to be cut; None with a round roller
    findings: tuple[Finding, ...] = ()  # of the design rules, worst first

    @property
    def label(self) -> str:
        """File and joint, for messages."""
        return f"{self.machine.origin}: joint.{self.name}"

    @property
    def joint(self) -> Joint:
        """The described joint."""
        return self.machine.joint[self.name]

    @cached_property
    def stresses(self) -> tuple[StrapStress, ...]:
        """Stresses of the strap at each place where it bends; none at a cam that is not convex."""
        over = [("roller", self.joint.output.radius)]
        if self.cam is not None:
            over = [("cam", self.cam.smallest_radius)] if self.cam.convex else []
        if self.joint.deflecting_roller is not None:
            over.append(("deflecting roller", self.joint.deflecting_roller.diameter / 2))
        tension = float(self.tension.max())
        return tuple(strap_stress(self.joint.strap, place, radius, tension) for place, radius in over)

    @cached_property
    def mass(self) -> JointMass:
        """Masses of the parts; a cam is made of the cylinder's material, as wide as the strap."""
        area = self.outline.area if self.outline else pi * self.joint.output.radius**2
        return JointMass(part_masses(self.joint, self.characteristic.full_travel, area), self.joint.body.mass)

    @property
    def air(self) -> AirConsumption:
        """Air consumption of one full stroke of one hose, filled from ambient to supply pressure."""
        supply, swept, dead = self.machine.supply, self.characteristic.swept_volume, self.joint.hose.dead_volume
        full, before = supply.pressure * (swept + dead), supply.ambient_pressure * dead
        mass = (full - before) / (GAS_CONSTANT * supply.temperature)
        return AirConsumption(swept, dead, mass / NORMAL_DENSITY * 1e3)

    @property
    def roller_torque(self) -> tuple[Array, Array]:
        """Angle (rad) and torque (N m) on a round roller of output.radius, each of shape (n,)."""
        radius = self.joint.output.radius
        return self.characteristic.travel / radius, self.characteristic.force * radius * self.pressure

    @property
    def torque(self) -> tuple[Array, Array]:
        """Angle (rad) and torque (N m) as built, with cam or roller, each of shape (n,)."""
        if self.cam is None:
            return self.roller_torque
        return self.cam.angle, np.full_like(self.cam.angle, self.cam.torque_constant * self.pressure)

    @property
    def mean_torque(self) -> float:
        """Work of one stroke over the stroke, N m; with a cam the torque at every angle."""
        return self.pressure * self.characteristic.swept_volume / self.stroke

    @property
    def stroke(self) -> float:
        """Output angle from the collapsed hose to the end of its travel, rad."""
        return self.characteristic.full_travel / self.joint.output.radius

    @property
    def tension(self) -> Array:
        """Tension of the strap at each travel, N, shape (n,)."""
        per_pressure = self.characteristic.force if self.cam is None else self.cam.tension
        return per_pressure * self.pressure

    def quantity_rows(self) -> list[list[str]]:
        """Return names and texts of the joint's main quantities."""
        joint, (angle, torque) = self.joint, self.torque
        counted = "hose, cylinder, shell, strap, cam"
        rows = [
            ["torque", f"{torque.min():.1f} to {torque.max():.1f} N m at {self.pressure / 1e5:g} bar gauge"],
            [
                "full travel",
                f"{degrees(angle[-1]):.1f} deg (working stroke {degrees(joint.stops.working_stroke):.0f} deg)",
            ],
            ["hose", f"{1e3 * joint.hose.width:.0f} mm wide, wrapped {degrees(joint.hose.wrap):.0f} deg"],
            ["cylinder", f"{1e3 * joint.cylinder.diameter:.1f} mm in diameter"],
            ["output", f"{joint.output.kind}, {1e3 * joint.output.radius:.2f} mm mean radius"],
            ["mass", f"{self.mass.body:.2f} kg, of which {self.mass.counted:.2f} kg {counted}"],
            ["air per stroke", f"{self.air.normal_litres:.2f} normal litres"],
        ]
        if self.outline is not None:
            rows.append(["shaft", shaft_advice(float(torque.max()), self.outline.bore)])
        return rows

    def plot(self) -> "Figure":
        """Draw the torque over the angle, on a round roller and as built, and the cam with the strap that makes it."""
        from layflat.plot.curves import design_figure  # noqa: PLC0415  # matplotlib takes long to import
        from layflat.plot.style import add_caption  # noqa: PLC0415

        curves = {"on a round roller": self.roller_torque} | ({} if self.cam is None else {"on the cam": self.torque})
        return add_caption(design_figure(curves, self.cam), f"{self._title}, at {self.pressure / 1e5:g} bar gauge")

    def _repr_html_(self) -> str:
        """Return tables of quantities and findings, for notebooks."""
        return html_table(self._title, (), self.quantity_rows()) + html_table(
            "findings of the design rules",
            ("severity", "where", "found", "action"),
            [(one.severity, one.where, one.what, one.right) for one in self.findings],
        )

    @property
    def _title(self) -> str:
        return f"{self.machine.name}, {self.name} joint"

    def columns(self) -> dict[str, Array]:
        """Return the columns of an exact Table 1 of the cam by name, (n,) each; raise DesignError without a cam.

        Names are `travel_mm`, `force_N`, `tension_N`, `lever_mm`, `cam_angle_deg`, `torque_Nm`, `normal_deg`, `x_mm`,
        `y_mm` and `curvature_radius_mm`.
        """
        cam = self.with_cam()
        return {
            "travel_mm": cam.travel * 1e3,
            "force_N": self.characteristic.force * self.pressure,
            "tension_N": self.tension,
            "lever_mm": cam.lever * 1e3,
            "cam_angle_deg": np.degrees(cam.angle),
            "torque_Nm": cam.lever * self.tension,
            "normal_deg": np.degrees(cam.normal),
            "x_mm": cam.profile[:, 0] * 1e3,
            "y_mm": cam.profile[:, 1] * 1e3,
            "curvature_radius_mm": cam.curvature_radius * 1e3,
        }

    def with_cam(self) -> Cam:
        """Return the cam; raise DesignError if the joint has none."""
        if self.cam is None:
            raise DesignError('"roller" has no cam', where=f"{self.label}.output.kind", right='give "cam"')
        return self.cam
