"""The cam as a part to be cut: its working profile, run-out, the flat for the strap's clamp, the hub and the bore.

The profile is kept as it is. The run-out goes on with the curvature that it begins with, for when the joint passes the
collapsed hose. Around the back runs the shortest convex line that holds flat and hub.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from layflat.design.cam import Cam
from layflat.errors import DesignError

Array = NDArray[np.float64]

BORES = tuple(size * 1e-3 for size in (4, 5, 6, 8, 10, 12, 15, 17, 20, 25, 30, 35, 40, 45, 50, 60))
"""Bores of common bearings and bushes, m."""

BORE_SHARE = 0.6
"""Greatest bore over the smallest lever arm."""

HUB_SHARE = 1.5
"""Hub diameter over bore: the least wall around the bore."""

CLAMP_SHARE = 0.5
"""Length of the flat for the strap's clamp over the smallest lever arm."""

RUN_OUT = np.radians(np.arange(1.0, 13.0))
"""Angles of the run-out's points beyond the profile, rad."""

HUB_POINTS = 180
ON_HULL = 1e-8
"""How far a point of the profile may lie inside the outline, m."""


@dataclass(frozen=True)
class Outline:
    """Closed outline of a cam in its own frame, origin on the output axis, anticlockwise, m.

    Args:
        points: shape (m, 2); the last is not the first again.
        working: how many of the first points are the working profile, in the order in which the strap winds up.
        clamp_end: end of the flat for the strap's clamp, (2,).
        bore: diameter, m.
        hub: diameter, m.
    """

    points: Array
    working: int
    clamp_end: Array
    bore: float
    hub: float

    @property
    def profile(self) -> Array:
        """The working profile, (n, 2)."""
        return self.points[: self.working]

    @property
    def area(self) -> float:
        """Area without the bore, m2."""
        x, y = self.points.T
        return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) - pi / 4 * self.bore**2


def cam_outline(cam: Cam, bore: float | None = None) -> Outline:
    """Return the outline of a cam.

    Args:
        cam: a convex cam.
        bore: diameter of the bore, m; without it the greatest common bore that leaves a wall.

    Raises:
        DesignError: the cam is not convex, turns too far for one plane, or the bore leaves no wall.
    """
    least = float(cam.lever.min())
    if not cam.convex:
        raise DesignError(
            f"not convex: radius of curvature falls to {cam.smallest_radius * 1e3:.4g} mm",
            where="cam",
            right="a longer stroke, or an output axis further from the strap point",
        )
    if bore is None:
        bore = max((size for size in BORES if size <= BORE_SHARE * least), default=BORE_SHARE * least)
    if not 0 < HUB_SHARE * bore / 2 < least:
        raise DesignError(
            f"a bore of {bore * 1e3:.4g} mm",
            where="cam",
            right=f"give one above 0 and below {2 * least / HUB_SHARE * 1e3:.4g} mm, for the smallest lever arm",
        )
    profile = cam.profile[::-1]
    last = cam.normal[-1]
    clamp_end = profile[0] - CLAMP_SHARE * least * np.array([-np.sin(last), np.cos(last)])
    over = cam.normal[0] + RUN_OUT
    rho = cam.curvature_radius[0]
    centre = profile[-1] - rho * np.array([np.cos(cam.normal[0]), np.sin(cam.normal[0])])
    run_out = centre + rho * np.stack((np.cos(over), np.sin(over)), axis=-1)
    around = np.linspace(0.0, 2 * pi, HUB_POINTS, endpoint=False)
    hub = HUB_SHARE * bore / 2 * np.stack((np.cos(around), np.sin(around)), axis=-1)
    back = _back(profile, np.vstack((run_out, clamp_end, hub)))
    return Outline(np.vstack((profile, back)), len(profile), clamp_end, bore, HUB_SHARE * bore)


def _back(profile: Array, rest: Array) -> Array:
    """Return the points of `rest` that the hull needs, anticlockwise from the profile's end to its start."""
    # Qhull drops points of a nearly straight profile, so only its ends are asked for, and the rest of it is checked.
    points = np.vstack((profile, rest))
    hull = ConvexHull(points)
    depth = -(hull.equations[:, :2] @ profile.T + hull.equations[:, 2:]).max(axis=0)
    if depth.max() > ON_HULL:
        raise DesignError(
            "the profile turns back over itself",
            where="cam",
            right="a shorter stroke: a cam in one plane turns by less than about 270 deg",
        )
    order = [int(i) for i in hull.vertices]
    back = [i for i in order if i >= len(profile)]
    first = next(k for k, i in enumerate(order) if i >= len(profile) and order[k - 1] < len(profile))
    turned = [i for i in order[first:] + order[:first] if i >= len(profile)]
    return points[turned] if back else np.empty((0, 2))
