"""The cam as a part to be cut: its working profile, run-out, the flat for the strap's clamp, the hub and the bore.

The profile is kept as it is. The run-out goes on with the curvature that it begins with, for when the joint passes the
collapsed hose. Around the back runs the shortest convex line that holds flat and hub.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from layflat.arrays import Array
from layflat.design.cam import Cam
from layflat.design.straplines import turned, unit
from layflat.errors import DesignError

BORES = tuple(size * 1e-3 for size in (4, 5, 6, 8, 10, 12, 15, 17, 20, 25, 30, 35, 40, 45, 50, 60))
"""Bores of common bearings and bushes, m."""
BORE_SHARE = 0.6  # greatest bore over the smallest lever arm
HUB_SHARE = 1.5  # hub diameter over bore: the least wall around the bore
CLAMP_SHARE = 0.5  # length of the flat for the strap's clamp over the smallest lever arm
RUN_OUT = np.radians(np.arange(1.0, 13.0))  # angles of the run-out's points beyond the profile, rad
HUB_POINTS = 180
ON_LINE = 1e-8  # how far the outline may reach over a line of the strap, m


@dataclass(frozen=True)
class Outline:
    """Closed outline of a convex cam in its own frame, origin on the output axis.

    Raise DesignError if the cam is not convex, turns too far for one plane, or the bore leaves no wall.
    """

    cam: Cam  # the cam
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
        points = np.vstack((self.profile, self._rest))
        if (points @ unit(self.cam.normal).T - self.cam.lever).max() > ON_LINE:
            right = "a shorter stroke: a cam in one plane turns by less than about 270 deg"
            raise DesignError("the profile turns back over itself", where="cam", right=right)

    @property
    def hub(self) -> float:
        """Diameter of the hub, m."""
        return HUB_SHARE * self.bore

    @property
    def profile(self) -> Array:
        """The working profile in the order in which the strap winds up, m, shape (n, 2)."""
        return self.cam.profile[::-1]

    @property
    def clamp_end(self) -> Array:
        """End of the flat for the strap's clamp, m, shape (2,)."""
        end: Array = self.profile[0] - CLAMP_SHARE * self.cam.lever.min() * turned(unit(self.cam.normal[-1]))
        return end

    @cached_property
    def points(self) -> Array:
        """Corners anticlockwise from the profile on, m, shape (m, 2); the last is not the first again."""
        from scipy.spatial import ConvexHull  # noqa: PLC0415  # SciPy takes long to import

        # Qhull drops points of a nearly straight profile, so only the back is asked for.
        points = np.vstack((self.profile, self._rest))
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
    def _rest(self) -> Array:
        """Points of run-out, clamp and hub, some of which are corners."""
        first, rho = self.cam.normal[0], self.cam.curvature_radius[0]
        centre = self.profile[-1] - rho * unit(first)
        run_out = centre + rho * unit(first + RUN_OUT)
        hub = self.hub / 2 * unit(np.linspace(0.0, 2 * pi, HUB_POINTS, endpoint=False))
        return np.vstack((run_out, self.clamp_end, hub))


def cam_outline(cam: Cam, bore: float | None = None) -> Outline:
    """Return the `Outline` of a cam; without a bore (m) with the greatest common one that leaves a wall."""
    if bore is None:
        greatest = BORE_SHARE * float(cam.lever.min())
        bore = max((size for size in BORES if size <= greatest), default=greatest)
    return Outline(cam, bore)
