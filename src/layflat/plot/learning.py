"""What repeats of a move have learnt: errors along the path, first and best, and from repeat to repeat."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.style import HEAD, LINES, QUIET, SHADE, figure

WIDTH, HIGH = 9.6, 3.4  # inches
LINE = 0.2  # of a legend, inches


class Repeats(NamedTuple):
    """Repeats from the first on."""

    rms: Sequence[float]  # distance of the tip along the path, mm
    most: Sequence[float]
    kept: Sequence[bool]  # whether it was the best so far


def learning_figure(
    time: Array, duration: float, tip: Mapping[str, Array], correction: Mapping[str, Array], repeats: Repeats
) -> Figure:
    """Draw errors along the path, the correction, and errors by repeat.

    Args:
        time: instants (s) from the beginning of the motion on; before it, a correction may already act.
        duration: of the motion, s.
        tip: its distance from where it should be, (instants,), mm, by what a repeat is called.
        correction: of the best one, (instants,), mrad, by joint.
        repeats: all of them.
    """
    more = LINE * ((max(len(tip), len(correction)) - 1) // 2)  # of legends with more than two names
    with figure(1, 3, width=WIDTH, height=HIGH + more, above=HEAD + more) as (made, (apart, added, counts)):
        curves = (apart, tip, "Tip from its path (mm)"), (added, correction, "Correction learnt (mrad)")
        for axes, shown, label in curves:
            axes.axvspan(0.0, duration, color=SHADE, zorder=0)
            for (name, values), style in zip(shown.items(), LINES[: len(shown)], strict=True):
                axes.plot(time, values, **style, label=name)
            axes.set_xlim(time[0], time[-1])
            axes.set_xlabel("Time (s); shaded: the motion")
            axes.set_ylabel(label)
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
        apart.set_ylim(bottom=0.0)
        added.axhline(0.0, **QUIET)
        _draw_repeats(counts, repeats)
    return made


def _draw_repeats(axes: Axes, repeats: Repeats) -> None:
    """Draw rms and greatest errors over repeats; those that were the best so far are filled."""
    number, kept = np.arange(len(repeats.rms)), np.array(repeats.kept, dtype=bool)
    for values, style, marker, label in (
        (repeats.most, LINES[1], "s", "greatest"),
        (repeats.rms, LINES[0], "o", "rms"),
    ):
        of = np.array(values)
        axes.plot(number, of, **style, marker=marker, ms=5, markerfacecolor="white", label=label)
        axes.plot(number[kept], of[kept], marker, color=style["color"], ms=5)
    axes.set_ylim(bottom=0.0)
    axes.set_xticks(number)
    axes.set_xlabel("Repeat (0: first run; filled: best so far)")
    axes.set_ylabel("Tip from its path (mm)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
