"""Torsion of a shaft in the cam's bore.

| symbol | meaning | unit |
|---|---|---|
| T | torque of the joint | N m |
| d | diameter of the shaft, which fills the bore | m |
| tau | shear stress at its surface | Pa |
"""

from math import cbrt, pi, sqrt

SHAFT_YIELD = 490e6  # of C45, quenched and tempered, up to 16 mm thick, Pa; source: ISO 683-1
SHEAR_SAFETY = 1.5  # yield over stress that is asked of a shaft


def shear_stress(torque: float, diameter: float) -> float:
    """Return the shear stress of a round shaft in torsion, tau = 16 T/(pi d^3), Pa (budynas2020, table 10.1)."""
    return 16.0 * torque / (pi * diameter**3)


def allowed_shear_stress() -> float:
    """Return what a shaft of C45 may bear, Pa: its yield in shear after von Mises, over the safety."""
    return SHAFT_YIELD / sqrt(3.0) / SHEAR_SAFETY


def shaft_advice(torque: float, bore: float) -> str:
    """Return how thick a shaft has to be that carries a torque (N m), and what to do if a bore (m) is thinner."""
    thinnest, stress = least_diameter(torque), shear_stress(torque, bore)
    text = f"{thinnest * 1e3:.1f} mm at least if it carries the torque (C45 with a safety of {SHEAR_SAFETY:g})"
    if bore >= thinnest:
        return text
    return f"{text}; in the bore of {bore * 1e3:.3g} mm it would bear {stress / 1e6:.0f} MPa: bolt the cam to the link"


def least_diameter(torque: float) -> float:
    """Return the diameter (m) of the thinnest shaft that may bear a torque (N m)."""
    return cbrt(16.0 * torque / (pi * allowed_shear_stress()))
