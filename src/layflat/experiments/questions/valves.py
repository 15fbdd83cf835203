"""Which valve: size, bandwidth, friction and dither, each with its own best gains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layflat.experiments.questions.tables import at_rest, moves_of
from layflat.plot.bars import draw_bars
from layflat.plot.style import figure as new_figure
from layflat.study import Study

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

TITLE = "Which valve?"
CAPTION = (
    "Each valve with the gains of a grid that suit it: of those that settle the slowest of three moves with 1 to 3 kg "
    "within 10 % of the shortest time, the pair that takes least air. Error at rest includes half of the ripple."
)
SLACK = 1.1
"""Gains that settle within so many times the shortest time are as good."""
WINDOW = 2.0
"""A move lasts so long, s; one that has not settled counts as this."""
ALIKE = 0.25
"""Times that differ by less than this share are alike."""

RESULTS = ("settling", "error", "ripple", "air")


def best(study: Study, frame: pandas.DataFrame) -> pandas.DataFrame:
    """By valve: settling of the slowest move (s), error at rest and ripple (deg), air of the run (l)."""
    moves = moves_of(frame)
    settling = frame[[f"settling.{move}" for move in moves]].fillna(np.inf).clip(upper=WINDOW)
    ripple = np.degrees(frame[[f"ripple.{move}" for move in moves]])
    own = frame.assign(
        settling=settling.max(axis=1), error=at_rest(frame, moves).mean(axis=1), ripple=ripple.mean(axis=1),
        air=frame["air_used"],
    )  # fmt: skip
    gains = [one.path for one in study.varied if one.relative]
    means = own.groupby(["variant", *gains])[list(RESULTS)].mean()
    chosen = {}
    for one in study.variants:
        mine = means.loc[one.name]
        good = mine[mine["settling"] <= SLACK * mine["settling"].min()]
        chosen[one.name] = good.loc[good["air"].idxmin()]
    import pandas  # noqa: PLC0415  # it comes with the extra of studies

    return pandas.DataFrame(chosen).T


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """A row a valve, a panel a result."""
    found = best(study, frame)
    labels = {
        "settling": "Slowest move settles in (s)",
        "error": "Error at rest (deg)",
        "ripple": "Ripple (deg)",
        "air": "Air (normal litres)",
    }
    with new_figure(1, 4, width=10.6, height=0.9 + 0.34 * len(found), beside=0.95) as (made, all_axes):
        for axes, (column, label) in zip(all_axes, labels.items(), strict=True):
            kinds = [0 if i == 0 else 1 for i in range(len(found))]
            names = list(found.index) if axes is all_axes[0] else []
            draw_bars(axes, names, found[column].tolist(), kinds=kinds)
            axes.set_xlabel(label)
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Which valve settles fastest, rests best, and takes least air; and how much that matters."""
    found = best(study, frame)
    quick, slow = found["settling"].idxmin(), found["settling"].idxmax()
    close, far = found["error"].idxmin(), found["error"].idxmax()
    lean, greedy = found["air"].idxmin(), found["air"].idxmax()

    def value(name: str, column: str) -> float:
        return float(found.loc[name, column])

    ratio = value(slow, "settling") / value(quick, "settling") - 1.0
    matter = "the valve hardly matters for settling" if ratio < ALIKE else "the valve matters for settling"
    return (
        f"With gains of its own for each, {matter}: {value(quick, 'settling'):.2f} s ({quick}) to "
        f"{value(slow, 'settling'):.2f} s ({slow}). At rest the joint is {value(close, 'error'):.2f} deg off "
        f"({close}) to {value(far, 'error'):.2f} deg ({far}); the same moves take {value(lean, 'air'):.1f} normal "
        f"litres ({lean}) to {value(greedy, 'air'):.1f} ({greedy})."
    )
