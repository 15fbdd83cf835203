"""What a joint weighs, part by part, and what air it uses.

The parts are those whose sizes the description gives; end plates, shaft, bearings, brake and fittings are the rest of
the joint's whole mass. Air is counted in normal litres (0 degC, 1.01325 bar), isothermal at the supply's temperature.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from layflat.design.outline import Outline
from layflat.machine import Joint
from layflat.machine.mass import part_masses
from layflat.machine.model import Supply
from layflat.physics.air import GAS_CONSTANT, NORMAL_DENSITY


@dataclass(frozen=True)
class Mass:
    """Masses of the parts, kg, and of the whole joint as described."""

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
    """Air of one full stroke of one hose from its collapsed state, at supply pressure.

    Args:
        swept_volume: m3.
        dead_volume: m3.
        normal_litres: taken from the supply.
    """

    swept_volume: float
    dead_volume: float
    normal_litres: float


def joint_mass(joint: Joint, full_travel: float, cam: Outline | None) -> Mass:
    """Estimate the mass of each part of a joint.

    Args:
        joint: the described joint.
        full_travel: of the strap point, m.
        cam: its outline, if it has one; it is made of the cylinder's material, as wide as the strap.
    """
    area = cam.area if cam else pi * joint.output.radius**2
    return Mass(part_masses(joint, full_travel, area), joint.body.mass)


def air_per_stroke(joint: Joint, swept_volume: float, supply: Supply) -> Air:
    """Return the air that fills one hose from ambient to supply pressure over a full stroke."""
    full = supply.pressure * (swept_volume + joint.hose.dead_volume)
    before = supply.ambient_pressure * joint.hose.dead_volume
    mass = (full - before) / (GAS_CONSTANT * supply.temperature)
    return Air(swept_volume, joint.hose.dead_volume, mass / NORMAL_DENSITY * 1e3)
