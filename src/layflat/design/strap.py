"""What the strap bears: tension and bending against yield.

| symbol | meaning | unit |
|---|---|---|
| F | tension | N |
| w, t, n | width and thickness of the strap, number of layers | m, m, 1 |
| E | modulus | Pa |
| rho | radius that it bends over | m |

Layers lie loose on each other, so each bends by itself; so does each fibre of a woven strap, whose diameter is then t
in the bending stress.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from layflat.machine.parts import Strap


@dataclass(frozen=True)
class StrapStress:
    """Stress of the strap at one place, Pa.

    Args:
        place: where it bends.
        bend_radius: rho there, m.
        tension: greatest tension, N.
        tensile: F/(w t n).
        bending: E t/(2 rho).
        yield_stress: what the strap bears.
    """

    place: str
    bend_radius: float
    tension: float
    tensile: float
    bending: float
    yield_stress: float

    @property
    def total(self) -> float:
        """Tension and bending together, Pa."""
        return self.tensile + self.bending

    @property
    def safety(self) -> float:
        """Yield stress over stress."""
        return self.yield_stress / self.total if self.total > 0 else inf


def tensile_stress(tension: float, width: float, thickness: float, layers: int) -> float:
    """F/(w t n), Pa."""
    return tension / (width * thickness * layers)


def bending_stress(modulus: float, thickness: float, bend_radius: float) -> float:
    """E t/(2 rho), Pa: the outer fibre of a thin strip; infinite over an edge."""
    return modulus * thickness / (2 * bend_radius) if bend_radius > 0 else inf


def strap_stress(strap: Strap, place: str, bend_radius: float, tension: float) -> StrapStress:
    """Stress of a described strap that bends over a radius (m) under a tension (N)."""
    return StrapStress(
        place,
        bend_radius,
        tension,
        tensile_stress(tension, strap.width, strap.thickness, strap.layers),
        bending_stress(strap.modulus, strap.fibre or strap.thickness, bend_radius),
        strap.yield_stress,
    )
