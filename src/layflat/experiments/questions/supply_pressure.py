"""Supply pressure: stiffness, settling, air."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from layflat.experiments.axis_one import GOOD_TIME
from layflat.experiments.questions.tables import Array
from layflat.plot.style import LINES, mark
from layflat.plot.style import figure as new_figure
from layflat.study import Study

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

TITLE = "What does the supply pressure change?"
CAPTION = (
    "Left: torque per turn of a joint that only the air shut in its hoses holds (no brake, no controller, no dither), "
    "and of the whole joint by what it gives at most when 4 N m come on top. Middle: a 40 deg step with 2 kg; crosses "
    "have not settled in 4 s. Right: air at rest, and of the step alone."
)
PRESSURE = "supply.pressure_gauge"
SHUT_LOAD, LOAD = 2.0, 4.0
"""Loads of the scenarios, N m."""
REST = 4.5
"""How long a run lasts, s."""
WITH, WITHOUT = "with dither", "without dither"


def _of(frame: pandas.DataFrame, variant: str, scenario: str, column: str) -> tuple[Array, Array]:
    """Supply pressures (bar, gauge), and the median of a column; what is not a number counts as infinite."""
    own = frame[(frame["variant"] == variant) & (frame["scenario"] == scenario)]
    median = own[column].fillna(inf).groupby(own[PRESSURE]).quantile(0.5, interpolation="higher")
    return median.index.to_numpy(dtype=float) / 1e5, median.to_numpy(dtype=float)


def results(frame: pandas.DataFrame) -> dict[str, Array]:
    """By supply pressure (bar): stiffnesses (N m per deg), settling (s), air at rest (l/min) and of a step (l)."""
    pressure, turned = _of(frame, WITHOUT, "push, air shut in", "steady_error.small.0")
    _, gave = _of(frame, WITH, "push 4 N m", "ripple.small.0")
    _, settling = _of(frame, WITH, "step", "settling.small.0")
    _, held = _of(frame, WITH, "hold", "air_used")
    _, leaked = _of(frame, WITHOUT, "hold", "air_used")
    _, stepped = _of(frame, WITH, "step", "air_used")
    return {
        "pressure": pressure,
        "air stiffness": SHUT_LOAD / np.degrees(np.abs(turned)),
        "joint stiffness": LOAD / np.degrees(gave),
        "settling": settling,
        "air at rest": 60.0 / REST * held,
        "leakage": 60.0 / REST * leaked,
        "air of a step": stepped - held,
    }


def figure(_: Study, frame: pandas.DataFrame) -> Figure:
    """Stiffness, settling and air against pressure."""
    found = results(frame)
    p = found["pressure"]
    with new_figure(1, 3, width=10.4, height=3.5) as (made, (stiffness, settling, air)):
        stiffness.plot(p, found["joint stiffness"], label="joint with brake and controller", **LINES[0])
        stiffness.plot(p, found["air stiffness"], label="air alone", **LINES[1])
        stiffness.set_ylabel("Stiffness (N m per deg)")
        settled = np.isfinite(found["settling"])
        settling.plot(p[settled], found["settling"][settled], **LINES[0], marker="o", ms=3)
        settling.plot(p[~settled], np.full(int((~settled).sum()), 4.0), "x", color=LINES[0]["color"])
        mark(settling, GOOD_TIME, f"goal, {GOOD_TIME:g} s")
        settling.set_ylabel("Time to settle (s)")
        air.plot(p, found["air at rest"], label="at rest, per minute", **LINES[0])
        air.plot(p, found["leakage"], label="the same without dither", **LINES[1])
        air.plot(p, found["air of a step"], label="of a 40 deg step", **LINES[2])
        air.set_yscale("log")
        air.set_yticks([0.3, 1, 3, 10, 30], ["0.3", "1", "3", "10", "30"])
        air.minorticks_off()
        air.set_ylabel("Air (normal litres)")
        for axes in (stiffness, settling):
            axes.set_ylim(0.0, 1.3 * axes.get_ylim()[1])
        air.set_ylim(top=8.0 * air.get_ylim()[1])
        for axes in (stiffness, air):
            axes.legend(loc="upper left", fontsize=8)
        for axes in (stiffness, settling, air):
            axes.set_xlabel("Supply pressure (bar, gauge)")
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Stiffness over the range, from where on the joint settles in good time, and what air goes for."""
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
