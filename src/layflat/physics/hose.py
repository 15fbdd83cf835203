"""The layflat hose around a cylinder: Eq. (1) of the paper, the volume it sweeps, and its polynomial form.

| symbol | meaning | unit |
|---|---|---|
| P | gauge pressure | Pa |
| R | outer radius of the cylinder | m |
| r | radius of the round inner roller | m |
| R_h | radius of the fully inflated hose (width / pi) | m |
| gamma | wrap angle of the collapsed hose | rad |
| alpha | contact angle from the clamp to the point of break-away | rad |
| c | ratio of roller angle to contact angle, in units of R/r | 1 |
| s | travel: output angle from the collapsed hose on | rad |
| K | torque per pressure = swept volume per radian of output | m3/rad |

Because the same K stands for torque and for volume, a joint built from it conserves energy.
"""

from math import cos, pi, sin
from typing import Any, NamedTuple

from layflat.jit import by_kind, law
from layflat.lazy import numpy as np
from layflat.physics.arrays import itemwise

STROKE_NODES = 41  # contact angles at which a roller's stroke is fitted, closest at both ends of the travel


class ConstantStroke(NamedTuple):
    """K that is constant over the travel (m3/rad), as with a cam."""

    k0: float  # m3/rad


class PolynomialStroke(NamedTuple):
    """K over the travel s as a polynomial, K = k0 + k1 s + ... + k4 s^4 (m3/rad^n)."""

    k0: float  # m3/rad
    k1: float  # m3/rad^2
    k2: float  # m3/rad^3
    k3: float  # m3/rad^4
    k4: float  # m3/rad^5


@law
def roller_torque(P, R, r, R_h, gamma, alpha):
    """Return the torque on a round inner roller, N m. Source: the paper's Eq. (1)."""
    return P * R * r / (2.0 * cos((pi - gamma) / 2.0)) * (pi * R_h - R * (gamma - alpha) / 2.0) * (1.0 - cos(alpha))


@law
def roller_travel(R, r, gamma, alpha, c):
    """Return the output angle of a roller once the hose has peeled from gamma to alpha, rad. Source: section 2.2."""
    return (gamma - alpha) * c * R / r


@law
def _peeled_integral(R, R_h, gamma, alpha):
    """Return the antiderivative by alpha of (pi R_h - R (gamma - alpha) / 2) (1 - cos(alpha)), m."""
    offset = pi * R_h - R * gamma / 2.0
    return offset * (alpha - sin(alpha)) + R / 2.0 * (alpha * alpha / 2.0 - alpha * sin(alpha) - cos(alpha))


@law
def peeled_volume(R, R_h, gamma, alpha, c):
    """Return the volume swept while the hose peels from gamma to alpha, m3: the integral of Eq. (1) over roller travel.

    Derived in docs/derivations.md; the roller's radius cancels.
    """
    lever = c * R * R / (2.0 * cos((pi - gamma) / 2.0))
    return lever * (_peeled_integral(R, R_h, gamma, gamma) - _peeled_integral(R, R_h, gamma, alpha))


@law
def _constant_torque(stroke, s):  # noqa: ARG001
    return stroke.k0


@law
def _torque(stroke, s):
    return stroke.k0 + s * (stroke.k1 + s * (stroke.k2 + s * (stroke.k3 + s * stroke.k4)))


@law
def _constant_volume(stroke, s):
    return stroke.k0 * s


@law
def _volume(stroke, s):
    """Return the swept volume at travel s, m3: the integral of the stroke's polynomial K(s).

    Summed in pairs (Estrin's scheme): a step waits for this sum, which is half as deep as Horner's.
    """
    low = stroke.k0 + s * (stroke.k1 / 2.0)
    high = (stroke.k2 / 3.0 + s * (stroke.k3 / 4.0)) + s * s * (stroke.k4 / 5.0)
    return s * (low + s * s * high)


torque_per_pressure = by_kind({ConstantStroke: _constant_torque, PolynomialStroke: _torque})
"""K at travel s, m3/rad: `torque_per_pressure(stroke, s)`."""

swept_volume = by_kind({ConstantStroke: _constant_volume, PolynomialStroke: _volume})
"""Volume swept from travel 0 to s, m3, the exact integral of K: `swept_volume(stroke, s)`."""


def inflated_radius(width: float) -> float:
    """Return R_h of a hose of a flat width (m), m."""
    return width / pi


class HoseGeometry(NamedTuple):
    """Sizes of a wrapped hose, with torque, travel and volume by Eq. (1); a size may be an array, an item a run."""

    width: float  # of the flat hose, m
    cylinder_radius: float  # R, m
    wrap: float  # gamma, rad
    contact_end: float  # alpha at full travel, rad
    peel_ratio: float  # c
    torque_factor: float = 1.0  # torque over that of Eq. (1), and so the volume

    @property
    def volume(self) -> float:
        """Volume swept over the full travel, m3."""
        R, R_h, gamma = self.cylinder_radius, inflated_radius(self.width), self.wrap
        return self.torque_factor * itemwise(peeled_volume, R, R_h, gamma, self.contact_end, self.peel_ratio)

    def full_travel(self, r: float = 1.0) -> float:
        """Return the output angle of a roller of radius r (m) at full travel, rad; at r = 1 the strap's travel, m."""
        return itemwise(roller_travel, self.cylinder_radius, r, self.wrap, self.contact_end, self.peel_ratio)

    def torque(self, alpha: Any, r: float = 1.0) -> Any:
        """Return torque per pressure on a roller of radius r (m) at contact angles (rad), m3; at r = 1 of force, m2."""
        law = itemwise(roller_torque, 1.0, self.cylinder_radius, r, inflated_radius(self.width), self.wrap, alpha)
        return self.torque_factor * law

    def stroke(self, r: float) -> PolynomialStroke:
        """Return K over the travel of a roller of radius r (m), fitted to Eq. (1)."""
        S = self.full_travel(r)
        t = 0.5 - 0.5 * np.cos(np.linspace(0.0, pi, STROKE_NODES))
        alphas = [self.wrap - share * S * r / (self.peel_ratio * self.cylinder_radius) for share in t]
        K = np.array([self.torque(alpha, r) for alpha in alphas])
        return PolynomialStroke(*(k / S**i for i, k in enumerate(np.polynomial.polynomial.polyfit(t, K, 4))))

    def even_stroke(self, r: float) -> ConstantStroke:
        """Return K of a cam with travel and mean torque of a roller of radius r (m)."""
        return ConstantStroke(self.volume / self.full_travel(r))
