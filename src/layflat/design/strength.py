"""Strength of the strap, by tension and bending, and of a shaft in the cam's bore, by torsion.

| symbol | meaning | unit |
|---|---|---|
| F | tension | N |
| w, t, n | width and thickness of the strap, number of layers | m, m, 1 |
| E | modulus | Pa |
| rho | radius that it bends over | m |
| T, d | torque of the joint, diameter of the shaft, which fills the bore | N m, m |
| tau | shear stress at the surface of the shaft | Pa |

Layers are not bonded, so that each bends by itself; so does each fibre of a woven strap, whose diameter is then t in
the bending stress.
"""

from dataclasses import dataclass
from math import cbrt, ceil, inf, pi, sqrt

from layflat.design.request import SizingRequest
from layflat.errors import DesignError
from layflat.machine.parts import Strap

STRIP_THICKNESSES = tuple(t * 1e-3 for t in (0.05, 0.1, 0.15, 0.2, 0.25, 0.3))  # of steel strip, m
WIDTH_SHARE = 0.45  # max width of a strap over the hose's, since two opposing straps pass each other
LEAST_WIDTH = 0.012  # of a strap, m
STRIP_LAYERS = (2, 4)  # numbers of layers, tried in this order


@dataclass(frozen=True)
class StrapStress:
    """Stress of the strap at one place, Pa."""

    location: str  # at which it bends
    bend_radius: float  # rho there, m
    tension: float  # max, N
    tensile: float  # F/(w t n)
    bending: float  # E t/(2 rho)
    yield_stress: float  # of the strap's material

    @property
    def total(self) -> float:
        """Sum of tensile and bending stress, Pa."""
        return self.tensile + self.bending

    @property
    def safety(self) -> float:
        """Yield stress over the total stress; infinite without stress."""
        return self.yield_stress / self.total if self.total > 0 else inf


def bending_stress(modulus: float, thickness: float, bend_radius: float) -> float:
    """Return the bending stress of a thin strip's outer fibre, E t/(2 rho), Pa; infinite over an edge.

    Args:
        modulus: E, Pa.
        thickness: t, m.
        bend_radius: rho, m; 0 for an edge.
    """
    return modulus * thickness / (2 * bend_radius) if bend_radius > 0 else inf


def strap_stress(strap: Strap, place: str, bend_radius: float, tension: float) -> StrapStress:
    """Return the stress of a described strap at one place.

    Args:
        strap: the strap.
        place: name of the place.
        bend_radius: over which it bends there, m.
        tension: tension of the strap, N.
    """
    tensile = tension / (strap.width * strap.thickness * strap.layers)
    bending = bending_stress(strap.modulus, strap.fibre or strap.thickness, bend_radius)
    return StrapStress(place, bend_radius, tension, tensile, bending, strap.yield_stress)


def choose_strap(request: SizingRequest, base: Strap, hose_width: float, tension: float, bend_radius: float) -> Strap:
    """Return the narrowest steel strap that withstands tension and bending with the request's margin.

    Args:
        request: margin, and width and thickness, which the strap gets if they are set.
        base: strap whose material is used.
        hose_width: width of the flat hose, m.
        tension: max, N.
        bend_radius: smallest, m.

    Raises:
        DesignError: no strap is strong enough.
    """
    allowed = base.yield_stress / request.stress_margin
    widest = request.strap_width or WIDTH_SHARE * hose_width
    thicknesses = STRIP_THICKNESSES if request.strap_thickness is None else (request.strap_thickness,)
    for layers in STRIP_LAYERS:
        left = [(t, allowed - bending_stress(base.modulus, t, bend_radius)) for t in thicknesses]
        sizes = [
            (max(LEAST_WIDTH, ceil(tension / (t * layers * stress) * 1e3) / 1e3), t) for t, stress in left if stress > 0
        ]
        width, t = min(sizes, default=(inf, 0.0))
        if width <= widest:
            return base.model_copy(update={"width": request.strap_width or width, "thickness": t, "layers": layers})
    load = f"{tension:.4g} N around {bend_radius * 1e3:.4g} mm with a margin of {request.stress_margin:.3g}"
    right = "a shorter stroke bends it less, a lower supply pressure pulls less; or ask for a smaller stress_margin"
    raise DesignError(f"no strap up to {widest * 1e3:.4g} mm wide bears {load}", where="size: strap", right=right)


SHAFT_YIELD = 490e6  # of C45, quenched and tempered, up to 16 mm thick, Pa; source: ISO 683-1
SHEAR_SAFETY = 1.5  # required yield over stress of a shaft


def shear_stress(torque: float, diameter: float) -> float:
    """Return the shear stress of a round shaft in torsion, tau = 16 T/(pi d^3), Pa (budynas2020, table 10.1)."""
    return 16.0 * torque / (pi * diameter**3)


def allowed_shear_stress() -> float:
    """Return the allowed shear stress of a shaft of C45, Pa: its shear yield after von Mises over the safety."""
    return SHAFT_YIELD / sqrt(3.0) / SHEAR_SAFETY


def shaft_advice(torque: float, bore: float) -> str:
    """Return advice on the diameter of a shaft that carries a torque (N m) in a bore (m)."""
    thinnest, stress = min_shaft_diameter(torque), shear_stress(torque, bore)
    text = f"{thinnest * 1e3:.1f} mm at least if it carries the torque (C45 with a safety of {SHEAR_SAFETY:g})"
    if bore >= thinnest:
        return text
    return f"{text}; in the bore of {bore * 1e3:.3g} mm it would bear {stress / 1e6:.0f} MPa: bolt the cam to the link"


def min_shaft_diameter(torque: float) -> float:
    """Return the min diameter (m) of a shaft that carries a torque (N m) within the allowed stress."""
    return cbrt(16.0 * torque / (pi * allowed_shear_stress()))
