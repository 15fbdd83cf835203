"""What a joint weighs, part by part, and what air it uses."""

from dataclasses import dataclass

from layflat.machine import Joint
from layflat.machine.model import Supply
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


def air_per_stroke(joint: Joint, swept_volume: float, supply: Supply) -> Air:
    """Return the air that fills one hose from ambient to supply pressure over a full stroke."""
    full = supply.pressure * (swept_volume + joint.hose.dead_volume)
    before = supply.ambient_pressure * joint.hose.dead_volume
    mass = (full - before) / (GAS_CONSTANT * supply.temperature)
    return Air(swept_volume, joint.hose.dead_volume, mass / NORMAL_DENSITY * 1e3)
