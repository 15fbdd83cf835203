"""Supply pressure: stiffness, settling, air."""

from math import inf

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.axis_one import GOOD_TIME
from layflat.plot.style import LINES, mark
from layflat.plot.style import figure as new_figure
from layflat.study import Study

PRESSURE = "supply.pressure_gauge"
SHUT_LOAD, LOAD = 2.0, 4.0  # loads of the scenarios, N m
REST = 4.5  # how long a run lasts, s
WITH, WITHOUT = "with dither", "without dither"


def results(frame: pandas.DataFrame) -> dict[str, Array]:
    """Return by supply pressure (bar): stiffnesses (N m per deg), settling (s), air at rest (l/min), of a step (l)."""
    by = [frame["variant"], frame["scenario"], frame[PRESSURE]]

    def of(variant: str, scenario: str, column: str) -> Array:
        median = frame[column].fillna(inf).groupby(by).quantile(0.5, interpolation="higher")
        return np.asarray(median.loc[variant, scenario], dtype=float)

    held = of(WITH, "hold", "air_used")
    return {
        "pressure": np.sort(frame[PRESSURE].unique()) / 1e5,
        "air stiffness": SHUT_LOAD / np.degrees(np.abs(of(WITHOUT, "push, air shut in", "steady_error.small.0"))),
        "joint stiffness": LOAD / np.degrees(of(WITH, "push 4 N m", "ripple.small.0")),
        "settling": of(WITH, "step", "settling.small.0"),
        "air at rest": 60.0 / REST * held,
        "leakage": 60.0 / REST * of(WITHOUT, "hold", "air_used"),
        "air of a step": of(WITH, "step", "air_used") - held,
    }


def figure(_: Study, frame: pandas.DataFrame) -> Figure:
    """Draw stiffness, settling and air against pressure."""
    found = results(frame)
    p, late = found["pressure"], ~np.isfinite(found["settling"])
    with new_figure(1, 3, width=10.4, height=3.5) as (made, (stiffness, settling, air)):
        for axes, label, column, order in (
            (stiffness, "joint with brake and controller", "joint stiffness", 0),
            (stiffness, "air alone", "air stiffness", 1),
            (air, "at rest, per minute", "air at rest", 0),
            (air, "the same without dither", "leakage", 1),
            (air, "of a 40 deg step", "air of a step", 2),
        ):
            axes.plot(p, found[column], label=label, **LINES[order])
        settling.plot(p[~late], found["settling"][~late], **LINES[0], marker="o", ms=3)
        settling.plot(p[late], np.full(int(late.sum()), 4.0), "x", color=LINES[0]["color"])
        mark(settling, GOOD_TIME, f"goal, {GOOD_TIME:g} s", ha="right")  # settling falls with pressure
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
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Say how stiffness goes over the range, from where on the joint settles in good time, and what air goes for."""
    found = results(frame)
    p, air, joint = found["pressure"], found["air stiffness"], found["joint stiffness"]
    low, high = p[0], p[-1]
    late = np.flatnonzero(found["settling"] > GOOD_TIME)
    if not len(late):
        settles = f"the joint settles within {GOOD_TIME:g} s at every pressure"
    elif late[-1] + 1 < len(p):
        settles = f"from {p[late[-1] + 1]:g} bar on the joint settles within {GOOD_TIME:g} s"
    else:
        last = found["settling"][-1]
        how = f"settles in {last:.2f} s" if np.isfinite(last) else "does not settle"
        settles = f"at {high:g} bar the joint {how} (within {GOOD_TIME:g} s at none up to there)"
    usual = int(np.argmin(np.abs(p - study.machine.supply.pressure_gauge / 1e5)))
    dithered = 100.0 * (1.0 - found["leakage"][usual] / found["air at rest"][usual])
    grows = "grows" if joint[-1] > 1.1 * joint[0] else "falls" if joint[-1] < 0.9 * joint[0] else "stays"
    return (
        f"From {low:g} to {high:g} bar the air alone gets {air[-1] / air[0]:.1f} times as stiff ({air[0]:.2f} to "
        f"{air[-1]:.2f} N m per deg); what the whole joint holds against {LOAD:g} N m {grows}, from {joint[0]:.1f} to "
        f"{joint[-1]:.1f} N m per deg. {settles[0].upper()}{settles[1:]}. At {p[usual]:g} bar a joint at rest takes "
        f"{found['air at rest'][usual]:.0f} normal litres a minute, {dithered:.0f} % of it because of dither, and a "
        f"step {found['air of a step'][usual]:.2f} more; at {high:g} bar {found['air at rest'][-1]:.0f} and "
        f"{found['air of a step'][-1]:.2f}."
    )
