"""The cam that keeps a joint's torque constant: the paper's Fig. 6, computed exactly instead of graphically.

| symbol | meaning | unit |
|---|---|---|
| s, f | travel of the strap point, force along it per pressure | m, m2 |
| K | torque per pressure, the same at all travels | m3/rad |
| phi | rotation of the cam | rad |
| p, psi | lever arm of the strap's line, angle of its normal in the joint's frame | m, rad |
| eta | angle of the normal in the cam's own frame, eta = psi - phi | rad |
| h(eta) | support function of the profile, h = p | m |
| rho | radius of curvature, rho = h + h'' | m |

Power balance: K dphi = f ds. The profile is the envelope of the strap's lines in the cam's frame,
x = h cos eta - h' sin eta, y = h sin eta + h' cos eta. A strap can only pull, so it must be convex: rho > 0.
Derived in docs/derivations-cam.md.

The part to be cut has the working profile, run-out, the flat for the strap's clamp, the hub and the bore. The run-out
continues the profile with its initial curvature, for a joint that moves beyond the collapsed hose. The back is the
convex hull of profile, flat and hub.
"""

from dataclasses import dataclass
from functools import cached_property
from math import degrees, isfinite, pi

import numpy as np

from layflat.arrays import Array
from layflat.design.characteristic import Characteristic
from layflat.design.straplines import StrapLine, direction_vector, rotate_quarter
from layflat.errors import DesignError


@dataclass(frozen=True)
class Cam:
    """Cam and its kinematics; arrays of shape (n,) over the travel, from the collapsed hose on."""

    torque_constant: float  # K, m3/rad: torque per gauge pressure
    travel: Array  # s, m
    angle: Array  # phi, rad, from 0
    lever: Array  # p, m
    alignment: Array  # component of the strap's tension along the shell's motion, over the tension
    line_normal: Array  # psi, rad
    normal: Array  # eta, rad, falling
    curvature_radius: Array  # rho, m; not positive where no strap can touch the cam
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
        """True if the cam can be made: the strap touches it everywhere."""
        return bool((self.curvature_radius > 0).all())

    @property
    def dip(self) -> float:
        """Max depth of the strap below the strap point's initial position: that of a slot in the cylinder's edge, m."""
        start = self.strap_point[0] - np.array(self.axis)
        return float((direction_vector(self.line_normal) @ start - self.lever).max())


def synthesise(characteristic: Characteristic, line: StrapLine, stroke: float) -> Cam:
    """Return the cam that rotates by a stroke over the hose's travel, at constant torque.

    The torque per pressure follows from the energy: K = swept volume / stroke.

    Args:
        characteristic: force of the hose over its travel.
        line: line of the strap between hose and cam.
        stroke: stroke of the cam, rad.

    Raises:
        DesignError: the stroke is not positive, no lever arm yields the torque, or the normal of the strap's line
            rotates backwards in the cam's frame.
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
    normal = direction_vector(eta)
    return Cam(
        torque_constant=K, travel=s, angle=phi, axis=line.axis,
        lever=lines.lever, alignment=lines.alignment, line_normal=lines.normal_angle, strap_point=lines.strap_point,
        normal=eta, curvature_radius=lines.lever + bend,
        profile=lines.lever[:, None] * normal + slope[:, None] * rotate_quarter(normal),
    )  # fmt: skip


BORE_DIAMETERS = tuple(size * 1e-3 for size in (4, 5, 6, 8, 10, 12, 15, 17, 20, 25, 30, 35, 40, 45, 50, 60))
"""Bores of common bearings and bushes, m."""
BORE_SHARE = 0.6  # max bore over the smallest lever arm
HUB_SHARE = 1.5  # hub diameter over bore, for a wall around the bore
CLAMP_SHARE = 0.5  # length of the flat for the strap's clamp over the smallest lever arm
RUN_OUT = np.radians(np.arange(1.0, 13.0))  # angles of the run-out's points beyond the profile, rad
HUB_POINTS = 180
ON_LINE = 1e-8  # tolerance of the outline beyond a line of the strap, m


@dataclass(frozen=True)
class Outline:
    """Closed outline of a convex cam in its own frame, origin on the output axis.

    Raises DesignError if the cam is not convex, rotates too far for one plane, or the bore leaves no wall.
    """

    cam: Cam
    bore: float  # diameter, m

    def __post_init__(self) -> None:
        if not self.cam.convex:
            what = f"not convex: radius of curvature falls to {self.cam.smallest_radius * 1e3:.4g} mm"
            right = "a longer stroke, or an output axis further from the strap point"
            raise DesignError(what, where="cam", right=right)
        greatest = 2 * float(self.cam.lever.min()) / HUB_SHARE
        if not 0 < self.bore < greatest:
            right = f"give one above 0 and below {greatest * 1e3:.4g} mm, for the smallest lever arm"
            raise DesignError(f"a bore of {self.bore * 1e3:.4g} mm", where="cam", right=right)
        points = np.vstack((self.profile, self._other_points))
        if (points @ direction_vector(self.cam.normal).T - self.cam.lever).max() > ON_LINE:
            right = "a shorter stroke: a cam in one plane turns by less than about 270 deg"
            raise DesignError("the profile turns back over itself", where="cam", right=right)

    @property
    def hub(self) -> float:
        """Diameter of the hub, m."""
        return HUB_SHARE * self.bore

    @property
    def profile(self) -> Array:
        """Working profile in the order in which the strap winds up, m, shape (n, 2)."""
        return self.cam.profile[::-1]

    @property
    def clamp_end(self) -> Array:
        """End of the flat for the strap's clamp, m, shape (2,)."""
        tangent = rotate_quarter(direction_vector(self.cam.normal[-1]))
        end: Array = self.profile[0] - CLAMP_SHARE * self.cam.lever.min() * tangent
        return end

    @cached_property
    def points(self) -> Array:
        """Corners anticlockwise from the profile on, m, shape (m, 2); the first is not repeated at the end."""
        from scipy.spatial import ConvexHull  # noqa: PLC0415  # SciPy takes long to import

        # Qhull drops points of a nearly straight profile, so only the back is taken from it.
        points = np.vstack((self.profile, self._other_points))
        order = ConvexHull(points).vertices
        on_back = order >= len(self.profile)
        first = int(np.argmax(on_back & ~np.roll(on_back, 1)))
        return np.vstack((self.profile, points[np.roll(order, -first)][np.roll(on_back, -first)]))

    @property
    def area(self) -> float:
        """Area without the bore, m2."""
        x, y = self.points.T
        return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) - pi / 4 * self.bore**2

    @property
    def _other_points(self) -> Array:
        """Points of run-out, clamp and hub, some of which are corners."""
        first, rho = self.cam.normal[0], self.cam.curvature_radius[0]
        centre = self.profile[-1] - rho * direction_vector(first)
        run_out = centre + rho * direction_vector(first + RUN_OUT)
        hub = self.hub / 2 * direction_vector(np.linspace(0.0, 2 * pi, HUB_POINTS, endpoint=False))
        return np.vstack((run_out, self.clamp_end, hub))


def cam_outline(cam: Cam, bore: float | None = None) -> Outline:
    """Return the `Outline` of a cam with a bore (m), by default the largest common one that leaves a wall.

    Raises:
        DesignError: as `Outline`.
    """
    if bore is None:
        greatest = BORE_SHARE * float(cam.lever.min())
        bore = max((size for size in BORE_DIAMETERS if size <= greatest), default=greatest)
    return Outline(cam, bore)
