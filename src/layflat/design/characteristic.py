"""What one hose gives over its travel: the force along the travel of its strap point, per pressure.

| symbol | meaning | unit |
|---|---|---|
| s | travel of the strap point, from the collapsed hose on | m |
| V | volume that the hose has swept | m3 |
| f | force along the travel per gauge pressure, f = F/P = dV/ds | m2 |
| c | roller angle per contact angle, in units of R/r | 1 |

By virtual work F ds = P dV, so one curve is force and volume alike, and nothing built from it can make energy.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from layflat.arrays import Array
from layflat.description.wrong import shown
from layflat.errors import DesignError
from layflat.machine import Joint
from layflat.physics.hose import HoseGeometry

POINTS = 601  # nodes of a curve that a law gives; its quintic spline is then as exact as the law
ORDER = 5  # of the spline, which goes through more points than that

Through = Callable[[Array, Array], tuple[Array, Array, Array]]
"""Yields the integral of y over rising x from the first point on, and y' and y'', at each point: shape (n,) each."""


def spline(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Lay a quintic spline through all points."""
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415  # SciPy takes a second to import

    curve = make_interp_spline(x, y, k=ORDER)
    return curve.antiderivative()(x), curve.derivative(1)(x), curve.derivative(2)(x)


def stencils(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Lay a polynomial through each point and its neighbours: the spline's values to 1e-6, without SciPy."""
    powers = np.arange(min(ORDER + 2, len(x)))
    near = np.clip(np.arange(len(x)) - ORDER // 2, 0, len(x) - len(powers))[:, None] + powers
    away = x[near] - x[:, None]
    scale = np.ptp(away, axis=1, keepdims=True)
    terms = np.linalg.solve((away / scale)[..., None] ** powers, y[near][..., None])[..., 0] / scale**powers
    steps = (terms[:-1] * np.diff(x)[:, None] ** (powers + 1) / (powers + 1)).sum(axis=1)
    return np.concatenate(([0.0], np.cumsum(steps))), terms[:, 1], 2 * terms[:, 2]


@dataclass(frozen=True)
class Characteristic:
    """Force per pressure over travel; DesignError if it has too few points, does not rise, or is not positive."""

    travel: Array  # s, m, shape (n,), rising from 0
    force: Array  # f, N/Pa = m2, shape (n,), positive
    source: str  # what the curve comes from, for reports
    fit_error: float = 0.0  # greatest distance of measured points from the curve, share of the greatest force
    through: Through = spline  # lays the curve through the nodes

    def __post_init__(self) -> None:
        where = f"characteristic from {self.source}"
        if self.travel.shape != self.force.shape or self.travel.ndim != 1 or self.travel.size <= ORDER:
            right = f"give as many of one as of the other, at least {ORDER + 1}"
            raise DesignError(f"{self.travel.size} travels and {self.force.size} forces", where=where, right=right)
        if not (np.isfinite(self.travel).all() and np.isfinite(self.force).all()):
            raise DesignError("holds a number that is not finite", where=where, right="every value must be a number")
        if self.travel[0] != 0.0 or not (np.diff(self.travel) > 0).all():
            raise DesignError("travel does not rise from 0", where=where, right="order it from the collapsed hose on")
        if not (self.force > 0).all():
            at = self.travel[int(np.argmax(self.force <= 0))]
            right = "end the travel before that: a smaller stroke, or a wider hose"
            raise DesignError(f"the hose gives no force at {at * 1e3:.4g} mm of travel", where=where, right=right)

    @cached_property
    def volume(self) -> Array:
        """V at each travel, m3, shape (n,)."""
        return self.through(self.travel, self.force)[0]

    @property
    def full_travel(self) -> float:
        """Travel at the end, m."""
        return float(self.travel[-1])

    @property
    def swept_volume(self) -> float:
        """V at the end of travel, m3: the work of one stroke per pressure."""
        return float(self.volume[-1])


def of_cylinder(joint: Joint, *, through: Through = spline) -> Characteristic:
    """Return the hose of a described joint by Eq. (1): F = T/r, s = c R (gamma - alpha); the roller's r cancels."""
    return _of_hose(joint.geometry, through)


def wrapped_hose(
    width: float, R: float, gamma: float, contact_end: float, c: float, *, through: Through = spline
) -> Characteristic:
    """Return a hose of flat width (m) and peel ratio c wrapped around a cylinder of outer radius R (m) by Eq. (1).

    The wrap of the collapsed hose is gamma, the contact angle at full travel `contact_end`, rad. Raise DesignError if a
    size is not positive, the wrap is over 180 deg, or the hose gives no force.
    """
    return _of_hose(HoseGeometry(width, R, gamma, contact_end, c), through)


def _of_hose(hose: HoseGeometry, through: Through) -> Characteristic:
    width, R, gamma, contact_end, c, _ = hose
    sizes = {"width": width, "radius": R, "wrap": gamma, "contact_end": contact_end, "peel_ratio": c}
    for name, value in sizes.items():
        is_number = isinstance(value, (int, float))
        if not (is_number and np.isfinite(value) and value > 0):
            raise DesignError(
                f"{value:.6g}" if is_number else shown(value),
                where=f"hose on a cylinder: {name}",
                right="give a positive number",
            )
    if not contact_end < gamma <= pi + 2e-6:
        what = f"wrap of {np.degrees(gamma):.6g} deg and contact_end of {np.degrees(contact_end):.6g} deg"
        right = "contact_end must be smaller than wrap, and wrap at most 180 deg"
        raise DesignError(what, where="hose on a cylinder", right=right)
    alpha = np.linspace(gamma, contact_end, POINTS)
    return Characteristic(c * R * (gamma - alpha), hose.torque(alpha), "Eq. (1)", through=through)
