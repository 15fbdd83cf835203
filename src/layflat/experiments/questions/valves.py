"""Choice of the valve: size, bandwidth, friction and dither, each with the gains that are best for it."""

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.experiments.questions import move_names, rest_errors
from layflat.plot.bars_and_maps import draw_bars
from layflat.plot.style import styled_figure as new_figure
from layflat.study import Study

SETTLING_SLACK = 1.1  # ratio to the shortest settling time within which gains are equally good
MOVE_DURATION = 2.0  # of a move, s; the settling time of one that has not settled
SIMILAR_FRACTION = 0.25  # relative difference below which settling times are similar

RESULT_LABELS = {
    "settling": "Slowest move settles in (s)",
    "error": "Error at rest (deg)",
    "ripple": "Ripple (deg)",
    "air": "Air (normal litres)",
}
"""Labels of the compared results in the figure, by column."""


def best_by_valve(study: Study, frame: pandas.DataFrame) -> pandas.DataFrame:
    """Return results by valve: settling of the slowest move (s), error at rest and ripple (deg), air of the run (l).

    They are means with the gains that use the least air of those within `SETTLING_SLACK` of the fastest.
    """
    moves = move_names(frame)
    settling = frame[[f"settling.{move}" for move in moves]].fillna(np.inf).clip(upper=MOVE_DURATION).max(axis=1)
    ripple = np.degrees(frame[[f"ripple.{move}" for move in moves]]).mean(axis=1)
    error = rest_errors(frame, moves).mean(axis=1)
    runs = frame.assign(settling=settling, error=error, ripple=ripple, air=frame["air_used"])
    gains = [variant.path for variant in study.varied if variant.relative]
    means = runs.groupby(["variant", *gains])[list(RESULT_LABELS)].mean()
    chosen = {}
    for variant in study.variants:
        valve_means = means.loc[variant.name]
        fast = valve_means[valve_means["settling"] <= SETTLING_SLACK * valve_means["settling"].min()]
        chosen[variant.name] = fast.loc[fast["air"].idxmin()]
    return pandas.DataFrame(chosen).T


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw the results of `best_by_valve` as bars, a row for each valve and a panel for each result."""
    results = best_by_valve(study, frame)
    with new_figure(1, 4, width=10.6, height=0.9 + 0.34 * len(results), beside=0.95) as (fig, all_axes):
        for axes, (column, label) in zip(all_axes, RESULT_LABELS.items(), strict=True):
            names = list(results.index) if axes is all_axes[0] else []
            draw_bars(axes, names, results[column].tolist(), kinds=[0, *[1] * (len(results) - 1)])
            axes.set_xlabel(label)
    return fig


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Return text on the valves with the best and worst settling, error at rest and use of air."""
    results = best_by_valve(study, frame)

    def ends(column: str) -> list[tuple[float, str]]:
        """Return the least and the greatest value of a column, each with its valve."""
        return [
            (float(results.loc[name, column]), name) for name in (results[column].idxmin(), results[column].idxmax())
        ]

    (time, quick), (slowest_time, slow) = ends("settling")
    (error, close), (greatest_error, far) = ends("error")
    (air, lean), (most_air, greedy) = ends("air")
    matters = "hardly matters" if slowest_time / time - 1.0 < SIMILAR_FRACTION else "matters"
    return (
        f"With gains of its own for each, the valve {matters} for settling: {time:.2f} s ({quick}) to "
        f"{slowest_time:.2f} s ({slow}). At rest the joint is {error:.2f} deg off ({close}) to "
        f"{greatest_error:.2f} deg ({far}); the same moves take {air:.1f} normal litres ({lean}) to "
        f"{most_air:.1f} ({greedy})."
    )
