"""Flat or curved plates in place of the cylinder, by virtual work. Derived in docs/derivations-cam.md.

The hose lies between a plate and a shell of the same shape that is hinged at the hose's clamp. Opened by the angle
psi, the gap between them fills with a hose whose cross-section is a stadium: flat where it touches, round at both
edges. Its volume follows from the geometry alone, and the moment about the hinge is M = P dV/dpsi.

| symbol | meaning | unit |
|---|---|---|
| w | width of the flat hose | m |
| L | length of the plate along the hose | m |
| R | radius of the plate's curvature; infinite for a flat plate | m |
| gamma | L/R, the wrap angle | rad |
| psi | angle by which the shell has opened | rad |
| d | chord of the shell, from the hinge to the strap point | m |
| s | travel of the strap point on its circle about the hinge, s = d psi | m |

In the collapsed state this is Eq. (1). Further on, Eq. (1) falls faster, because on a cylinder the hose also peels off
along the wrap. On a flat plate nothing shifts along the wrap, so nothing peels.
"""

from dataclasses import dataclass
from math import asin, degrees, inf, isfinite, isinf, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.design.characteristic import CURVE_POINTS, Characteristic
from layflat.errors import DesignError

FULL_GAP = 0.999  # share of the inflated diameter up to which the gap opens: at 1 the hose touches along a line only
USED_FALL = 0.5  # share of its first force at which a hose's travel ends by default: about that of the paper's cylinder


@dataclass(frozen=True)
class Plate:
    """Plate with a hinged shell, both flat or both curved; raises DesignError for a wrap over 180 deg or no size."""

    width: float  # of the flat hose, m
    length: float  # along the hose, from the clamp to the strap point, m
    radius: float = inf  # of curvature, m; infinite for a flat plate

    def __post_init__(self) -> None:
        for name in ("width", "length", "radius"):
            value = getattr(self, name)
            if not value > 0 or (name != "radius" and not isfinite(value)):
                raise DesignError(f"{value:.6g} m", where=f"plate: {name}", right="give a positive length in metres")
        if self.wrap > pi:
            what = f"{self.length:.6g} m on a radius of {self.radius:.6g} m wraps {degrees(self.wrap):.4g} deg"
            right = f"at most 180 deg: {pi * self.radius:.4g} m"
            raise DesignError(what, where="plate: length", right=right)

    @property
    def wrap(self) -> float:
        """Wrap angle gamma, rad; zero on a flat plate."""
        return 0.0 if isinf(self.radius) else self.length / self.radius

    @property
    def chord(self) -> float:
        """Distance d of the strap point from the hinge, m."""
        return self.length if isinf(self.radius) else 2 * self.radius * sin(self.wrap / 2)

    @property
    def full_opening(self) -> float:
        """Angle psi at which the widest gap is the inflated diameter 2 w/pi, rad."""
        widest = self.length if isinf(self.radius) else self.radius * sin(min(self.wrap, pi / 2))
        return 2 * asin(min(1.0, FULL_GAP * self.width / (pi * widest)))

    def _moments(self) -> tuple[float, float]:
        """Return integrals along the plate of gap and gap squared, per 2 sin(psi/2) and its square: m2, m3."""
        gamma, R = self.wrap, self.radius
        if gamma < 1e-4:
            return self.length**2 / 2, self.length**3 / 3
        return R**2 * (1 - np.cos(gamma)), R**3 * (gamma / 2 - sin(2 * gamma) / 4)

    def volume(self, opening: ArrayLike) -> Array:
        """Return V between plate and shell when opened by psi, m3."""
        first, second = self._moments()
        half = np.asarray(opening, dtype=float) / 2
        flat = 2 * self.width * first * np.sin(half) * np.cos(half)
        return np.asarray(flat - pi * second * np.sin(half) ** 2 * np.cos(half))

    def moment(self, opening: ArrayLike) -> Array:
        """Return the moment about the hinge per pressure, dV/dpsi, m3/rad."""
        first, second = self._moments()
        psi = np.asarray(opening, dtype=float)
        sine, cosine = np.sin(psi / 2), np.cos(psi / 2)
        return np.asarray(self.width * first * np.cos(psi) - pi / 2 * second * sine * (2 * cosine**2 - sine**2))


def plate_characteristic(plate: Plate, opening: float | None = None) -> Characteristic:
    """Return the characteristic of a hose between plate and shell.

    The shell opens by an angle (rad), by default until the force falls to half. Raise DesignError if the angle is not
    positive, or more than the inflated hose fills.
    """
    if opening is None:
        opening = _used_opening(plate)
    if not 0 < opening <= plate.full_opening:
        right = f"above 0 and at most {degrees(plate.full_opening):.4g} deg, where the hose is fully inflated"
        raise DesignError(f"{degrees(opening):.6g} deg", where="plate: opening", right=right)
    psi = np.linspace(0.0, opening, CURVE_POINTS)
    kind = "flat" if isinf(plate.radius) else "curved"
    return Characteristic(plate.chord * psi, plate.moment(psi) / plate.chord, f"a {kind} plate by virtual work")


def _used_opening(plate: Plate) -> float:
    """Return the angle (rad) at which the moment has fallen to `USED_FALL` of the initial one, or the full opening."""
    from scipy.optimize import brentq  # noqa: PLC0415  # SciPy takes long to import

    first = float(plate.moment(0.0))

    def above(psi: float) -> float:
        return float(plate.moment(psi)) - USED_FALL * first

    full = plate.full_opening
    return float(brentq(above, 0.0, full)) if above(full) < 0 else full
