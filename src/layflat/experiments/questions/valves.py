"""Which valve: size, bandwidth, friction and dither, each with its own best gains."""

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.experiments.questions.tables import at_rest, moves_of
from layflat.plot.bars_and_maps import draw_bars
from layflat.plot.style import figure as new_figure
from layflat.study import Study

SLACK = 1.1  # gains that settle within so many times the shortest time are as good
WINDOW = 2.0  # a move lasts so long, s; one that has not settled counts as this
ALIKE = 0.25  # times that differ by less than this share are alike

RESULTS = {
    "settling": "Slowest move settles in (s)",
    "error": "Error at rest (deg)",
    "ripple": "Ripple (deg)",
    "air": "Air (normal litres)",
}
"""What is compared, and how it is called in the figure."""


def best(study: Study, frame: pandas.DataFrame) -> pandas.DataFrame:
    """By valve: settling of the slowest move (s), error at rest and ripple (deg), air of the run (l)."""
    moves = moves_of(frame)
    settling = frame[[f"settling.{move}" for move in moves]].fillna(np.inf).clip(upper=WINDOW).max(axis=1)
    ripple = np.degrees(frame[[f"ripple.{move}" for move in moves]]).mean(axis=1)
    error = at_rest(frame, moves).mean(axis=1)
    own = frame.assign(settling=settling, error=error, ripple=ripple, air=frame["air_used"])
    gains = [one.path for one in study.varied if one.relative]
    means = own.groupby(["variant", *gains])[list(RESULTS)].mean()
    chosen = {}
    for one in study.variants:
        mine = means.loc[one.name]
        good = mine[mine["settling"] <= SLACK * mine["settling"].min()]
        chosen[one.name] = good.loc[good["air"].idxmin()]
    return pandas.DataFrame(chosen).T


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw a row a valve, a panel a result."""
    found = best(study, frame)
    with new_figure(1, 4, width=10.6, height=0.9 + 0.34 * len(found), beside=0.95) as (made, all_axes):
        for axes, (column, label) in zip(all_axes, RESULTS.items(), strict=True):
            names = list(found.index) if axes is all_axes[0] else []
            draw_bars(axes, names, found[column].tolist(), kinds=[0, *[1] * (len(found) - 1)])
            axes.set_xlabel(label)
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Say which valve settles fastest, rests best, and takes least air; and how much that matters."""
    found = best(study, frame)

    def ends(column: str) -> list[tuple[float, str]]:
        return [(float(found.loc[name, column]), name) for name in (found[column].idxmin(), found[column].idxmax())]

    (time, quick), (longest, slow) = ends("settling")
    (error, close), (greatest, far) = ends("error")
    (air, lean), (most, greedy) = ends("air")
    matters = "hardly matters" if longest / time - 1.0 < ALIKE else "matters"
    return (
        f"With gains of its own for each, the valve {matters} for settling: {time:.2f} s ({quick}) to {longest:.2f} s "
        f"({slow}). At rest the joint is {error:.2f} deg off ({close}) to {greatest:.2f} deg ({far}); the same moves "
        f"take {air:.1f} normal litres ({lean}) to {most:.1f} ({greedy})."
    )
