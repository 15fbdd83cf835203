"""What was measured and what is simulated, over a log: fitted on a white ground, judged on a grey one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.plot.style import LINES, QUIET, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


class Compared(NamedTuple):
    """A signal of a log: its name, its unit as shown, and samples of time (s), measured, simulated, fitted."""

    name: str
    unit: str
    time: Array
    measured: Array
    simulated: Array
    fitted: NDArray[np.bool_]


SHADE = "#eeeeee"
MEASURED = {**QUIET, "linewidth": 2.2, "color": "#b5b5b5"}


def measured_and_simulated(signals: Sequence[Compared]) -> Figure:
    """A row a signal: on the left both, on the right the error, simulated less measured."""
    rows = len(signals)
    with figure(rows, 2, width=11.0, height=1.9 * rows + 0.9, share_x=True, head=True) as (made, axes):
        for row, signal in enumerate(signals):
            both, error = axes[2 * row], axes[2 * row + 1]
            both.plot(signal.time, signal.measured, label="measured", **MEASURED)
            both.plot(signal.time, signal.simulated, label="simulated", **{**LINES[0], "linewidth": 1.0})
            error.plot(
                signal.time, signal.simulated - signal.measured, **{**LINES[1], "linestyle": "-", "linewidth": 0.8}
            )
            both.set_ylabel(f"{signal.name}\n({signal.unit})")
            error.set_ylabel(f"error ({signal.unit})")
            judged = np.flatnonzero(~signal.fitted)
            if len(judged) and len(judged) < len(signal.time):
                for one in (both, error):
                    one.axvspan(signal.time[judged[0]], signal.time[judged[-1]], color=SHADE, lw=0)
        axes[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.2)
        for one in axes[-2:]:
            one.set_xlabel("Time (s)")
    return made
