"""A joint's whole design from its description: curve, cam, strap, findings, mass and air."""

from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from layflat.arrays import Array
from layflat.design.cam import Cam
from layflat.design.characteristic import Characteristic
from layflat.design.findings import Finding
from layflat.design.outline import Outline
from layflat.design.strength import StrapStress, strap_stress
from layflat.errors import DesignError
from layflat.machine import Joint, Machine
from layflat.machine.parts import part_masses
from layflat.physics.air import GAS_CONSTANT, NORMAL_DENSITY


@dataclass(frozen=True)
class Mass:
    """Masses of the parts whose sizes the description gives, kg, and of the whole joint as described."""

    parts: dict[str, float]
    body: float

    @property
    def counted(self) -> float:
        """Sum of the parts, kg."""
        return sum(self.parts.values())

    @property
    def rest(self) -> float:
        """End plates, shaft, bearings, brake and fittings: what the parts leave of the whole, kg."""
        return self.body - self.counted


@dataclass(frozen=True)
class Air:
    """Air of one full stroke of one hose from its collapsed state, at supply pressure."""

    swept_volume: float  # m3
    dead_volume: float  # m3
    normal_litres: float  # taken from the supply, at 0 degC and 1.01325 bar; isothermal at the supply's temperature


@dataclass(frozen=True)
class JointDesign:
    """The whole design of one joint."""

    machine: Machine  # the machine it belongs to
    name: str  # the joint's name there
    pressure: float  # gauge supply pressure, Pa; all torques, tensions and stresses hold at this pressure
    characteristic: Characteristic  # force of one hose over its travel
    cam: Cam | None  # the exact cam; None with a round roller
    outline: Outline | None  # the cam as a part to be cut; None with a round roller
    findings: tuple[Finding, ...] = ()  # what the design rules find, worst first

    @property
    def where(self) -> str:
        """File and joint, for messages."""
        return f"{self.machine.origin}: joint.{self.name}"

    @property
    def joint(self) -> Joint:
        """The described joint."""
        return self.machine.joint[self.name]

    @cached_property
    def stresses(self) -> tuple[StrapStress, ...]:
        """Stresses of the strap, wherever it bends."""
        over = [("roller", self.joint.output.radius)]
        if self.cam is not None:
            over = [("cam", self.cam.smallest_radius)] if self.cam.convex else []
        if self.joint.deflecting_roller is not None:
            over.append(("deflecting roller", self.joint.deflecting_roller.diameter / 2))
        tension = float(self.tension.max())
        return tuple(strap_stress(self.joint.strap, place, radius, tension) for place, radius in over)

    @cached_property
    def mass(self) -> Mass:
        """Mass part by part; a cam is made of the cylinder's material, as wide as the strap."""
        area = self.outline.area if self.outline else pi * self.joint.output.radius**2
        return Mass(part_masses(self.joint, self.characteristic.full_travel, area), self.joint.body.mass)

    @property
    def air(self) -> Air:
        """Air of one full stroke of one hose, which it fills from ambient to supply pressure."""
        supply, swept, dead = self.machine.supply, self.characteristic.swept_volume, self.joint.hose.dead_volume
        full, before = supply.pressure * (swept + dead), supply.ambient_pressure * dead
        mass = (full - before) / (GAS_CONSTANT * supply.temperature)
        return Air(swept, dead, mass / NORMAL_DENSITY * 1e3)

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

    def columns(self) -> dict[str, Array]:
        """Return what Table 1 gives for the cam, exact: columns (n,), units in names; raise DesignError without one."""
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
            raise DesignError('"roller"', where=f"{self.where}.output.kind", right='give "cam" to have one')
        return self.cam
