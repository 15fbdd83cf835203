"""Characteristic of a hose: the force along the travel of its strap point, per pressure, over the travel.

| symbol | meaning | unit |
|---|---|---|
| s | travel of the strap point, from the collapsed hose on | m |
| V | volume that the hose has swept | m3 |
| f | force along the travel per gauge pressure, f = F/P = dV/ds | m2 |
| c | roller angle per contact angle, in units of R/r | 1 |

By virtual work F ds = P dV, so that one curve defines force and volume, and energy is conserved in all that uses it.
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

CURVE_POINTS = 601  # nodes of a computed curve, for which the error of its quintic spline is negligible
SPLINE_ORDER = 5  # a curve needs more points than this

Through = Callable[[Array, Array], tuple[Array, Array, Array]]
"""Function of rising x and y, (n,), that returns the integral of y from the first point, y' and y'', (n,) each."""


def spline(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return integral from the first point, y' and y'' of the quintic spline through all points, at these points."""
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415  # SciPy takes a second to import

    curve = make_interp_spline(x, y, k=SPLINE_ORDER)
    return curve.antiderivative()(x), curve.derivative(1)(x), curve.derivative(2)(x)


def stencils(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return the same as `spline` to 1e-6, by a polynomial through each point and its neighbours, without SciPy."""
    powers = np.arange(min(SPLINE_ORDER + 2, len(x)))
    near = np.clip(np.arange(len(x)) - SPLINE_ORDER // 2, 0, len(x) - len(powers))[:, None] + powers
    away = x[near] - x[:, None]
    scale = np.ptp(away, axis=1, keepdims=True)
    terms = np.linalg.solve((away / scale)[..., None] ** powers, y[near][..., None])[..., 0] / scale**powers
    steps = (terms[:-1] * np.diff(x)[:, None] ** (powers + 1) / (powers + 1)).sum(axis=1)
    return np.concatenate(([0.0], np.cumsum(steps))), terms[:, 1], 2 * terms[:, 2]


@dataclass(frozen=True)
class Characteristic:
    """Force per pressure over travel; raises DesignError for too few points, falling travel or no positive force."""

    travel: Array  # s, m, shape (n,), rising from 0
    force: Array  # f, N/Pa = m2, shape (n,), positive
    source: str  # origin of the curve, for messages
    fit_error: float = 0.0  # max distance of measured points from the curve, over the greatest force
    through: Through = spline  # interpolation between the nodes

    def __post_init__(self) -> None:
        where = f"characteristic from {self.source}"
        if self.travel.shape != self.force.shape or self.travel.ndim != 1 or self.travel.size <= SPLINE_ORDER:
            right = f"give as many of one as of the other, at least {SPLINE_ORDER + 1}"
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


def cylinder_characteristic(joint: Joint, *, through: Through = spline) -> Characteristic:
    """Return the curve of a joint's hose by Eq. (1): F = T/r, s = c R (gamma - alpha); the roller's r cancels."""
    return _hose_characteristic(joint.geometry, through)


def wrapped_hose(
    width: float, R: float, gamma: float, contact_end: float, c: float, *, through: Through = spline
) -> Characteristic:
    """Return the characteristic of a hose that is wrapped around a cylinder, by Eq. (1).

    Args:
        width: width of the flat hose, m.
        R: outer radius of the cylinder, m.
        gamma: wrap angle of the collapsed hose, rad.
        contact_end: contact angle at full travel, rad.
        c: peel ratio.
        through: interpolation of the curve.

    Raises:
        DesignError: a size is not positive, the wrap is over 180 deg, or the hose yields no force.
    """
    return _hose_characteristic(HoseGeometry(width, R, gamma, contact_end, c), through)


def _hose_characteristic(hose: HoseGeometry, through: Through) -> Characteristic:
    """Return the characteristic of a hose on a cylinder by Eq. (1); raise DesignError for impossible sizes."""
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
    alpha = np.linspace(gamma, contact_end, CURVE_POINTS)
    return Characteristic(c * R * (gamma - alpha), hose.torque(alpha), "Eq. (1)", through=through)
