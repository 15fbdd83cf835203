"""Hysteresis curves: torque against angle, there and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from layflat.plot.style import LINES, figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class CurveLike(Protocol):
    """Angles (rad) and torques (N m) of a closed curve, forward and back."""

    @property
    def angle(self) -> NDArray[np.float64]:
        """In rad."""

    @property
    def torque(self) -> NDArray[np.float64]:
        """In N m."""


def draw_hysteresis(axes: Axes, curve: CurveLike, label: str, order: int) -> None:
    """Draw one curve with arrows that show its sense."""
    line = LINES[order % len(LINES)]
    angle, torque = np.degrees(curve.angle), curve.torque
    closed = np.append(angle, angle[0]), np.append(torque, torque[0])
    axes.plot(*closed, label=label, **line)
    half = len(angle) // 2
    for at in (int(0.55 * half), half + int(0.45 * half)):
        axes.annotate(
            "",
            (angle[at + 12], torque[at + 12]),
            (angle[at], torque[at]),
            arrowprops={"arrowstyle": "-|>", "color": line["color"], "lw": 1.2},
        )


def hysteresis_curves(drawn: Mapping[str, CurveLike], *, against: str = "Output angle from mid-stroke (deg)") -> Figure:
    """Draw curves in one frame, torque against angle."""
    with figure() as (made, (axes,)):
        for order, (label, curve) in enumerate(drawn.items()):
            draw_hysteresis(axes, curve, label, order)
        axes.set_xlabel(against)
        axes.set_ylabel("Torque (N m)")
        axes.set_ylim(0, 1.12 * max(float(curve.torque.max()) for curve in drawn.values()))
        axes.legend()
    return made
