"""The cam and the strap lines that envelop it: the paper's Fig. 6."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from layflat.plot.style import LINES, QUIET, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = 25
"""Strap lines drawn."""


class CamLike(Protocol):
    """A cam over the travel of its hose: angles (rad, (n,)), points (m, (n, 2)) and the output axis (m)."""

    @property
    def angle(self) -> NDArray[np.float64]:
        """Angle of the cam."""

    @property
    def profile(self) -> NDArray[np.float64]:
        """Envelope in the cam's frame, origin on the axis."""

    @property
    def strap_point(self) -> NDArray[np.float64]:
        """Where the strap leaves the shell, in the joint's frame."""

    @property
    def axis(self) -> tuple[float, float]:
        """Output axis in the joint's frame."""


def cam_procedure(cam: CamLike) -> Figure:
    """Draw strap lines in the cam's frame at evenly spaced cam angles, and the profile that they envelop."""
    profile, away = 1e3 * cam.profile, 1e3 * (cam.strap_point - np.array(cam.axis))
    c, s = np.cos(cam.angle), np.sin(cam.angle)
    seen = np.stack([away[:, 0] * c + away[:, 1] * s, away[:, 1] * c - away[:, 0] * s], axis=-1)
    with figure(width=5.6, height=5.6, head=True) as (made, (axes,)):
        for i in np.searchsorted(cam.angle, np.linspace(cam.angle[0], cam.angle[-1], SHOWN)):
            ends = np.array([seen[i], profile[i], profile[i] + 0.25 * (profile[i] - seen[i])])
            axes.plot(ends[:, 0], ends[:, 1], **{**QUIET, "linewidth": 0.6})
        axes.plot(seen[:, 0], seen[:, 1], label="where the strap leaves the shell", **LINES[1])
        axes.plot(profile[:, 0], profile[:, 1], label="cam profile", **{**LINES[0], "linewidth": 2.5})
        axes.plot(0.0, 0.0, "+", color="black", ms=10)
        axes.annotate("output axis", (0, 0), xytext=(0, -8), textcoords="offset points", ha="center", va="top")
        axes.set_aspect("equal")
        axes.set_xlabel("Along the cam (mm)")
        axes.set_ylabel("Across the cam (mm)")
        axes.legend(ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return made
