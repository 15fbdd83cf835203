"""Supply pressure: stiffness, settling, air."""

from math import inf

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.axis_one import SETTLING_GOAL
from layflat.plot.style import SERIES_STYLES, draw_mark
from layflat.plot.style import styled_figure as new_figure
from layflat.study import Study

PRESSURE_COLUMN = "supply.pressure_gauge"
SHUT_LOAD, PUSH_LOAD = 2.0, 4.0  # loads of the scenarios, N m
HOLD_DURATION = 4.5  # of each run, s
DITHER_VARIANT, NO_DITHER_VARIANT = "with dither", "without dither"


def results_by_pressure(frame: pandas.DataFrame) -> dict[str, Array]:
    """Return medians over runs, by supply pressure (bar, gauge), each (pressures,), by name.

    Names are pressure, air stiffness, joint stiffness (N m per deg), settling (s), air at rest, leakage (normal l/min)
    and air of a step (normal l).
    """
    keys = [frame["variant"], frame["scenario"], frame[PRESSURE_COLUMN]]

    def median_column(variant: str, scenario: str, column: str) -> Array:
        """Return the medians of a column, (pressures,); runs that diverged count as infinite."""
        median = frame[column].fillna(inf).groupby(keys).quantile(0.5, interpolation="higher")
        return np.asarray(median.loc[variant, scenario], dtype=float)

    held = median_column(DITHER_VARIANT, "hold", "air_used")
    return {
        "pressure": np.sort(frame[PRESSURE_COLUMN].unique()) / 1e5,
        "air stiffness": SHUT_LOAD
        / np.degrees(np.abs(median_column(NO_DITHER_VARIANT, "push, air shut in", "steady_error.small.0"))),
        "joint stiffness": PUSH_LOAD / np.degrees(median_column(DITHER_VARIANT, "push 4 N m", "ripple.small.0")),
        "settling": median_column(DITHER_VARIANT, "step", "settling.small.0"),
        "air at rest": 60.0 / HOLD_DURATION * held,
        "leakage": 60.0 / HOLD_DURATION * median_column(NO_DITHER_VARIANT, "hold", "air_used"),
        "air of a step": median_column(DITHER_VARIANT, "step", "air_used") - held,
    }


def figure(_: Study, frame: pandas.DataFrame) -> Figure:
    """Draw stiffness, settling and air against pressure."""
    results = results_by_pressure(frame)
    p, unsettled = results["pressure"], ~np.isfinite(results["settling"])
    with new_figure(1, 3, width=10.4, height=3.5) as (fig, (stiffness, settling, air)):
        for axes, label, column, order in (
            (stiffness, "joint with brake and controller", "joint stiffness", 0),
            (stiffness, "air alone", "air stiffness", 1),
            (air, "at rest, per minute", "air at rest", 0),
            (air, "the same without dither", "leakage", 1),
            (air, "of a 40 deg step", "air of a step", 2),
        ):
            axes.plot(p, results[column], label=label, **SERIES_STYLES[order])
        settling.plot(p[~unsettled], results["settling"][~unsettled], **SERIES_STYLES[0], marker="o", ms=3)
        settling.plot(p[unsettled], np.full(int(unsettled.sum()), 4.0), "x", color=SERIES_STYLES[0]["color"])
        draw_mark(settling, SETTLING_GOAL, f"goal, {SETTLING_GOAL:g} s", ha="right")  # settling falls with pressure
        air.set_yscale("log")
        air.set_yticks([0.3, 1, 3, 10, 30], ["0.3", "1", "3", "10", "30"])
        air.minorticks_off()
        for axes, label in (
            (stiffness, "Stiffness (N m per deg)"),
            (settling, "Time to settle (s)"),
            (air, "Air (normal litres)"),
        ):
            axes.set(xlabel="Supply pressure (bar, gauge)", ylabel=label)
            low, high = axes.get_ylim()
            axes.set_ylim((low, 8.0 * high) if axes is air else (0.0, 1.3 * high))
            if axes is not settling:
                axes.legend(loc="upper left", fontsize=8)
    return fig


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Return text on stiffness over pressure, the pressure from which the joint settles in time, and the use of air."""
    results = results_by_pressure(frame)
    p, air, joint = results["pressure"], results["air stiffness"], results["joint stiffness"]
    low, high = p[0], p[-1]
    late_indices = np.flatnonzero(results["settling"] > SETTLING_GOAL)
    if not len(late_indices):
        settles = f"the joint settles within {SETTLING_GOAL:g} s at every pressure"
    elif late_indices[-1] + 1 < len(p):
        settles = f"from {p[late_indices[-1] + 1]:g} bar on the joint settles within {SETTLING_GOAL:g} s"
    else:
        last = results["settling"][-1]
        outcome = f"settles in {last:.2f} s" if np.isfinite(last) else "does not settle"
        settles = f"at {high:g} bar the joint {outcome} (within {SETTLING_GOAL:g} s at none up to there)"
    usual = int(np.argmin(np.abs(p - study.machine.supply.pressure_gauge / 1e5)))
    dithered = 100.0 * (1.0 - results["leakage"][usual] / results["air at rest"][usual])
    grows = "grows" if joint[-1] > 1.1 * joint[0] else "falls" if joint[-1] < 0.9 * joint[0] else "stays"
    return (
        f"From {low:g} to {high:g} bar the air alone gets {air[-1] / air[0]:.1f} times as stiff ({air[0]:.2f} to "
        f"{air[-1]:.2f} N m per deg); what the whole joint holds against {PUSH_LOAD:g} N m {grows}, from "
        f"{joint[0]:.1f} to "
        f"{joint[-1]:.1f} N m per deg. {settles[0].upper()}{settles[1:]}. At {p[usual]:g} bar a joint at rest takes "
        f"{results['air at rest'][usual]:.0f} normal litres a minute, {dithered:.0f} % of it because of dither, and a "
        f"step {results['air of a step'][usual]:.2f} more; at {high:g} bar {results['air at rest'][-1]:.0f} and "
        f"{results['air of a step'][-1]:.2f}."
    )
