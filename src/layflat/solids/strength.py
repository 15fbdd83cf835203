"""Stresses of a joint's parts by hand formulas, each with its source and the safety that it needs.

| symbol | meaning | unit |
|---|---|---|
| p, w | gauge pressure, width of the flat hose | Pa, m |
| F, T, M | force, torque, bending moment | N, N m, N m |
| b, h, t, d | width, height, thickness, diameter of a section | m |
| s, e | distance between supports, lever of a force | m |
| A | stress area of a screw (ISO 898-1) | m2 |
| sigma, tau | normal and shear stress | Pa |
| C0, s0 | static load rating of a bearing, its static safety (ISO 76) | N, 1 |

Formulas are on the safe side: screws support a bar without clamping it, loads of one shaft act in one plane, and an
external force adds to a screw's preload in full. Beams and rings are those of budynas2020 (Roark's formulas).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf, pi, sqrt
from typing import Literal

from layflat.design.strength import SHEAR_SAFETY, shear_stress
from layflat.design.summary import Finding

YIELD_SAFETY = SHEAR_SAFETY  # required yield over stress of metal parts
STATIC_SAFETY = 1.0  # required s0 of a bearing that oscillates slowly and need not run quietly (ISO 76)
WEBBING_SAFETY = 3.0  # required breaking load over tension of polyester webbing (EN 12195-2)
PARTING_SAFETY = 1.2  # required preload over the force that parts a joint
HOSE_FRICTION = 0.3  # coefficient between a hose and the metal that clamps it; assumed: rubber on machined metal
RING_MOMENT = 1.0 / pi  # moment below two opposed forces on a ring over F R (budynas2020, table 9.2, case 1)
SCREW_TORQUE_SHARE = 0.2  # tightening torque over preload and diameter, at a friction of 0.14 (VDI 2230)


@dataclass(frozen=True)
class Strength:
    """Stress of a part beside the stress at which it fails."""

    where: str  # part and place
    formula: str
    stress: float  # Pa, or N for a load
    limit: float  # yield stress, breaking stress or rated load, in the same unit
    required: float  # min safety
    source: str  # of the formula and the required safety
    unit: Literal["Pa", "N"] = "Pa"

    @property
    def allowed(self) -> float:
        """Allowed stress (Pa) or load (N): the limit over the required safety."""
        return self.limit / self.required

    @property
    def safety(self) -> float:
        """Limit over stress; infinite without stress."""
        return self.limit / self.stress if self.stress > 0 else inf

    def __str__(self) -> str:
        scale, unit = (1e-6, "MPa") if self.unit == "Pa" else (1.0, "N")
        values = f"{self.stress * scale:.4g} {unit} of {self.limit * scale:.4g} {unit}"
        return f"{self.where}: {values}, safety {self.safety:.3g} ({self.formula}; {self.source})"


def check_strength(strength: Strength) -> Finding | None:
    """Return an error if a part fails, a warning if its safety is below the required one, else None."""
    if strength.safety >= strength.required:
        return None
    right = f"give it a safety of {strength.required:g}: a larger section, a stronger material or less pressure"
    what = f"safety {strength.safety:.3g} ({strength.formula})"
    return Finding("error" if strength.safety < 1 else "warning", "strength", strength.where, what, right)


def section_modulus(width: float, height: float, hole: float = 0.0) -> float:
    """Return the section modulus of a rectangle with a hole in its middle, (b h^3 - b d^3)/(6 h), m3.

    Args:
        width: b, along the hole's axis, m.
        height: h, in the plane of bending, m.
        hole: diameter d, m.
    """
    return width * (height**3 - hole**3) / (6 * height)


def hose_pull(pressure: float, hose_width: float) -> float:
    """Return the pull of an inflated hose on its end clamp, p w^2/pi, N: pressure on its circular section."""
    return pressure * hose_width**2 / pi


def clamp_bar(pressure: float, seal_width: float, pitch: float, width: float, height: float, limit: float) -> Strength:
    """Return the bending stress of an end clamp's bar between two screws.

    Pressure that creeps under the bar loads it evenly: M = p b s^2/8 (budynas2020, table 8.1, case 2e).

    Args:
        pressure: p, gauge, Pa.
        seal_width: b of the pressed strip, along the hose, m.
        pitch: s of the screws, m.
        width: of the bar, along the hose, m.
        height: h of the bar, m.
        limit: yield stress, Pa.
    """
    stress = pressure * seal_width * pitch**2 / 8 / section_modulus(width, height)
    source = "budynas2020, table 8.1, case 2e"
    return Strength("end clamp: bar", "p b s^2/8 over b h^2/6", stress, limit, YIELD_SAFETY, source)


def clamp_force(opening_force: float, pull: float, friction: float = HOSE_FRICTION) -> float:
    """Return the force of all screws of an end clamp: it holds it shut, and the hose by friction on both faces, N.

    Args:
        opening_force: pressure times the pressed area, N.
        pull: of the hose, N.
        friction: coefficient between hose and metal.
    """
    return opening_force + pull / (2 * friction)


def clamp_screws(force: float, count: int, stress_area: float, limit: float) -> Strength:
    """Return the tension of an end clamp's screws, F/(n A).

    Args:
        force: of all screws, N, from `clamp_force`.
        count: number n of screws.
        stress_area: A, m2.
        limit: proof stress, Pa.
    """
    stress = force / (count * stress_area)
    return Strength("end clamp: screws", "F/(n A)", stress, limit, YIELD_SAFETY, "ISO 898-1, VDI 2230")


def tightening_torque(preload: float, diameter: float) -> float:
    """Return the torque that tightens a dry screw (diameter in m) to a preload (N), 0.2 F d, N m (VDI 2230)."""
    return SCREW_TORQUE_SHARE * preload * diameter


def end_plate(force: float, lever: float, width: float, hole: float, thickness: float, limit: float) -> Strength:
    """Return the stress of an end plate across its bearing, bent in its plane and pulled.

    sigma = F e/W + F/((b - d) t), with W of the section through the bearing's hole (budynas2020, section 8.1).

    Args:
        force: of the bearing: strap tensions and the link's load, N.
        lever: e from the bearing to the plate's screws, m.
        width: b of the plate, m.
        hole: d, outer diameter of the bearing, m.
        thickness: t, m.
        limit: yield stress, Pa.
    """
    stress = force * lever / section_modulus(thickness, width, hole) + force / ((width - hole) * thickness)
    return Strength(
        "end plate", "F e/W + F/((b - d) t)", stress, limit, YIELD_SAFETY, "budynas2020, sections 7.1 and 8.1"
    )


def bearing_load(load: float, static_rating: float) -> Strength:
    """Return the static load of a bearing beside its rating, s0 = C0/F (ISO 76).

    Args:
        load: radial, N.
        static_rating: C0, N.
    """
    return Strength("bearing", "s0 = C0/F", abs(load), static_rating, STATIC_SAFETY, "ISO 76", "N")


def bearing_reactions(loads: Sequence[tuple[float, float]], span: float) -> tuple[float, float]:
    """Return the forces of the two bearings of a shaft against its loads, N.

    Args:
        loads: forces in one plane and their distances from the first bearing, N and m.
        span: s of the bearings, m.
    """
    second = sum(force * place for force, place in loads) / span
    return sum(force for force, _ in loads) - second, second


def shaft(loads: Sequence[tuple[float, float]], span: float, diameter: float, torque: float, limit: float) -> Strength:
    """Return the von Mises stress of a round shaft in two bearings, bent by forces and twisted by a torque.

    sigma = 32 M/(pi d^3), tau = 16 T/(pi d^3), where M is the largest moment along the shaft; shear of the forces is
    counted as tau = 4 V/(3 A) where it is larger (budynas2020, sections 8.1 and 10.2).

    Args:
        loads: forces in one plane, N, and their distances from the first bearing, m; also beyond the bearings.
        span: s of the bearings, m.
        diameter: d, m.
        torque: T, N m.
        limit: yield stress, Pa.
    """
    first, second = bearing_reactions(loads, span)
    forces = sorted([(0.0, -first), (span, -second), *((place, force) for force, place in loads)])
    moment = shear = largest_moment = largest_shear = 0.0
    for (place, force), (following, _) in zip(forces, [*forces[1:], forces[-1]], strict=True):
        shear += force
        moment += shear * (following - place)
        largest_moment = max(largest_moment, abs(moment))
        largest_shear = max(largest_shear, abs(shear))
    twist = shear_stress(torque, diameter)
    bent = hypot(32 * largest_moment / (pi * diameter**3), sqrt(3) * twist)
    sheared = sqrt(3) * (4 * largest_shear / (3 * pi / 4 * diameter**2) + twist)
    source = "budynas2020, sections 8.1 and 10.2"
    return Strength("shaft", "sqrt(sigma^2 + 3 tau^2)", max(bent, sheared), limit, YIELD_SAFETY, source)


def hinge_webbing(tension: float, width: float, thickness: float, limit: float) -> Strength:
    """Return the stress of the webbing that hinges the shell, F/(b t).

    Args:
        tension: F, N.
        width: b, m.
        thickness: t, m.
        limit: breaking stress, Pa.
    """
    return Strength("hinge: webbing", "F/(b t)", tension / (width * thickness), limit, WEBBING_SAFETY, "EN 12195-2")


def calliper_arm(force: float, lever: float, width: float, height: float, limit: float) -> Strength:
    """Return the bending stress of a calliper's arm at its root, F e/(b h^2/6) (budynas2020, table 8.1, case 1a).

    Args:
        force: of the pad, N.
        lever: e from the pad to the root, m.
        width: b, m.
        height: h in the direction of the force, m.
        limit: yield stress, Pa.
    """
    stress = force * lever / section_modulus(width, height)
    return Strength("calliper: arm", "F e over b h^2/6", stress, limit, YIELD_SAFETY, "budynas2020, table 8.1, case 1a")
