"""What was measured and what is simulated, over a log: fitted on a white ground, validated on a grey one."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.plot.style import HEAD, LINES, QUIET, SHADE, figure

MEASURED = {**QUIET, "linewidth": 2.2, "color": "#b5b5b5"}
FEW = 200  # up to so many samples are marked one by one


class Compared(NamedTuple):
    """A signal of a log: its name, its unit as shown, and samples of time (s), measured, simulated, fitted."""

    name: str
    unit: str
    time: Array
    measured: Array
    simulated: Array
    fitted: NDArray[np.bool_]


def measured_and_simulated(signals: Sequence[Compared]) -> Figure:
    """Draw a row per signal: on the left both, on the right the error, simulated less measured."""
    rows = len(signals)
    with figure(rows, 2, width=11.0, height=1.9 * rows + 0.9, above=HEAD, beside=0.2, between=0.95) as (made, axes):
        for row, signal in enumerate(signals):
            both, error = axes[2 * row], axes[2 * row + 1]
            known = np.isfinite(signal.measured)
            few = known.sum() <= FEW
            marked = {"marker": "o", "markersize": 3.5} if few else {}
            known |= not few  # between few samples a line is drawn, and none over a gap in many
            time, measured, simulated = signal.time[known], signal.measured[known], signal.simulated[known]
            both.plot(time, measured, label="measured", **{**MEASURED, **marked})
            both.plot(time, simulated, label="simulated", **{**LINES[0], "linewidth": 1.0})
            error.axhline(0.0, **{**QUIET, "linewidth": 0.8})
            error.plot(time, simulated - measured, **{**LINES[1], "linestyle": "-", "linewidth": 0.8})
            unit = f" ({signal.unit})" if signal.unit else ""
            both.set_ylabel(f"{signal.name.replace('_', ' ')}\n{unit.strip()}".rstrip())
            error.set_ylabel(f"error{unit}")
            if len(left := np.flatnonzero(~signal.fitted)):
                for one in (both, error):
                    one.axvspan(signal.time[left[0]], signal.time[left[-1]], color=SHADE, lw=0, zorder=0)
        handles, labels = axes[0].get_legend_handles_labels()
        if any(not signal.fitted.all() for signal in signals):
            handles.append(Patch(color=SHADE))
            labels.append("not fitted")
        axes[0].legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.2)
        made.align_ylabels(axes[0::2])
        made.align_ylabels(axes[1::2])
        for one in axes:
            one.margins(x=0.01)
        for one in axes[-2:]:
            one.set_xlabel("Time (s)")
    return made
