"""The cam that keeps the torque constant: the paper's Fig. 6, exact instead of graphical.

| symbol | meaning | unit |
|---|---|---|
| s, f | travel of the strap point, force along it per pressure | m, m2 |
| K | torque per pressure, the same at all travels | m3/rad |
| phi | angle that the cam has turned | rad |
| p, psi | lever arm of the strap's line, angle of its normal in the joint's frame | m, rad |
| eta | angle of the normal in the cam's own frame, eta = psi - phi | rad |
| h(eta) | support function of the profile, h = p | m |
| rho | radius of curvature, rho = h + h'' | m |

Power balance: K dphi = f ds. The profile is the envelope of the strap's lines in the cam's frame,
x = h cos eta - h' sin eta, y = h sin eta + h' cos eta. A strap can only pull, so it must be convex: rho > 0.
Derived in docs/derivations-cam.md.
"""

from dataclasses import dataclass
from math import degrees, isfinite

import numpy as np

from layflat.arrays import Array
from layflat.design.characteristic import Characteristic
from layflat.design.straplines import StrapLine, turned, unit
from layflat.errors import DesignError


@dataclass(frozen=True)
class Cam:
    """A cam and how it runs; arrays of shape (n,) over the travel, from the collapsed hose on."""

    torque_constant: float  # K, m3/rad: torque per gauge pressure
    travel: Array  # s, m
    angle: Array  # phi, rad, from 0
    lever: Array  # p, m
    alignment: Array  # share of the strap's tension that acts along the shell's motion
    line_normal: Array  # psi, rad
    normal: Array  # eta, rad, falling
    curvature_radius: Array  # rho, m; not positive where the cam can't be made
    profile: Array  # points (n, 2) of the envelope, m, in the cam's frame: the joint's at phi = 0, with its origin at O
    strap_point: Array  # A, m, in the joint's frame, shape (n, 2)
    axis: tuple[float, float]  # O, m, in the joint's frame

    @property
    def stroke(self) -> float:
        """Angle from the collapsed hose to the end of travel, rad."""
        return float(self.angle[-1])

    @property
    def tension(self) -> Array:
        """Strap tension per gauge pressure, m2, shape (n,)."""
        return self.torque_constant / self.lever

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature, m."""
        return float(self.curvature_radius.min())

    @property
    def convex(self) -> bool:
        """Whether the cam can be made: the strap touches it everywhere."""
        return bool((self.curvature_radius > 0).all())

    @property
    def dip(self) -> float:
        """How far the strap runs below the strap point's first place, m: that deep a slot the cylinder's edge needs."""
        return float((unit(self.line_normal) @ (self.strap_point[0] - np.array(self.axis)) - self.lever).max())


def synthesise(characteristic: Characteristic, line: StrapLine, stroke: float) -> Cam:
    """Return the cam that turns by `stroke` (rad) while the hose goes through its travel, at constant torque.

    Energy settles the torque per pressure: K = swept volume / stroke. Raise DesignError if the stroke is not positive,
    no lever arm gives the torque, or the strap's lines turn back.
    """
    if not (isfinite(stroke) and stroke > 0):
        raise DesignError(f"stroke of {degrees(stroke):.6g} deg", where="cam", right="give a positive stroke")
    s, f = characteristic.travel, characteristic.force
    K = characteristic.swept_volume / stroke
    phi = characteristic.volume / K
    lines = line.lines(s, f, K)
    eta = lines.normal_angle - phi
    back = np.diff(eta) >= 0
    if back.any():
        what = f"the strap's line turns faster than the cam at {s[int(np.argmax(back))] * 1e3:.4g} mm of travel"
        right = "a longer stroke, or an output axis further from the strap point"
        raise DesignError(what, where="cam", right=right)
    _, slope, bend = (values[::-1] for values in characteristic.through(eta[::-1], lines.lever[::-1]))
    normal = unit(eta)
    return Cam(
        torque_constant=K, travel=s, angle=phi, axis=line.axis,
        lever=lines.lever, alignment=lines.alignment, line_normal=lines.normal_angle, strap_point=lines.strap_point,
        normal=eta, curvature_radius=lines.lever + bend,
        profile=lines.lever[:, None] * normal + slope[:, None] * turned(normal),
    )  # fmt: skip
