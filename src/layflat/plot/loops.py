"""Torque-angle loops."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from layflat.plot.style import LINES, figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class LoopLike(Protocol):
    """Angles (rad) and torques (N m) of a closed loop, forward and back."""

    @property
    def angle(self) -> NDArray[np.float64]:
        """In rad."""

    @property
    def torque(self) -> NDArray[np.float64]:
        """In N m."""


def draw_loop(axes: Axes, loop: LoopLike, label: str, order: int) -> None:
    """Draw one loop with arrows that show its sense."""
    line = LINES[order % len(LINES)]
    angle, torque = np.degrees(loop.angle), loop.torque
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


def loops(drawn: Mapping[str, LoopLike], *, against: str = "Output angle from mid-stroke (deg)") -> Figure:
    """Loops side by side in one frame, torque against angle."""
    with figure() as (made, (axes,)):
        for order, (label, loop) in enumerate(drawn.items()):
            draw_loop(axes, loop, label, order)
        axes.set_xlabel(against)
        axes.set_ylabel("Torque (N m)")
        axes.set_ylim(0, 1.12 * max(float(loop.torque.max()) for loop in drawn.values()))
        axes.legend()
    return made
