"""Level of the brake and inertia of the payload: settling, and how much inertia a joint carries."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.experiments.axis_one import GOOD_TIME, SCAN
from layflat.experiments.bench import INERTIA_PER_TORQUE
from layflat.experiments.questions.tables import Array, grid, hysteresis, inertia_per_torque, limits
from layflat.plot.maps import draw_map, edges
from layflat.plot.style import figure as new_figure
from layflat.study import Study

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

TITLE = "How much brake, for how much inertia?"
CAPTION = (
    "Time to settle after a 40 deg step (hatched: not in 4 s) over total hysteresis, which the brake sets, and "
    "inertia. Below the solid line every inertia from the paper's comparison on (dotted) settles within 1.5 s, below "
    "the dashed line within 4 s, in the median with the neighbouring fields. The vertical line is the paper's brake."
)

ENOUGH = 0.8
"""What carries this share of the most carries nearly as much."""


def _levels(study: Study, brakes: Array) -> Array:
    """Total hysteresis, %, of the paper's joint with its brake at these levels."""
    machine = study.machine
    without, full = (hysteresis(machine, level) for level in (0.0, 1.0))
    return without + brakes * (full - without)


def _fields(study: Study, frame: pandas.DataFrame) -> list[tuple[str, Array, Array, Array, Array]]:
    """Of each variant: name, brakes, their hysteresis (%), inertia per torque, times to settle (inertias, brakes)."""
    found = []
    for one in study.variants:
        own = frame[frame["variant"] == one.name]
        brakes, payloads, times = grid(own, "scenario.brake", "scenario.payload", "settling.small.0")
        found.append((one.name, brakes, _levels(study, brakes), inertia_per_torque(one.machine, payloads), times))
    return found


def _limits(ratios: Array, times: Array, allowed: float) -> Array:
    """Limits of the median with the neighbouring brakes and inertias: single fields settle late by chance."""
    from scipy.ndimage import median_filter  # noqa: PLC0415  # takes long to import

    return limits(ratios, median_filter(times, size=3, mode="nearest"), allowed)


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """A map for each variant of the gains."""
    fields = _fields(study, frame)
    with new_figure(1, len(fields), width=8.6, height=4.3, above=0.62) as (made, all_axes):
        for axes, (name, _, levels, ratios, times) in zip(all_axes, fields, strict=True):
            draw_map(axes, levels, ratios, times, f"Time to settle (s), {name}", low=0.0, high=SCAN)
            for allowed, dashes in ((GOOD_TIME, "-"), (SCAN, "--")):
                limit = _limits(ratios, times, allowed)
                style: dict[str, Any] = {"color": "#c23b4e", "linestyle": dashes, "linewidth": 2.0}
                axes.plot(levels, np.where(limit > 0.0, limit, np.nan), label=f"limit in {allowed:g} s", **style)
            axes.axvline(_levels(study, np.ones(1))[0], color="#1b1b1b", linewidth=1.0)
            axes.axhline(INERTIA_PER_TORQUE, color="#1b1b1b", linewidth=1.0, linestyle=":")
            axes.set_yscale("log")
            axes.set_xlim(*edges(levels))
            axes.set_ylim(*edges(ratios, log=True))
            axes.set_xlabel("Total hysteresis (%)")
            axes.set_ylabel("Inertia per torque (kg m$^2$ per N m)")
        all_axes[0].legend(loc="upper right", fontsize=8)
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Where each variant carries most, what the paper's brake carries, and where the joint stalls."""
    sentences = []
    for name, brakes, levels, ratios, times in _fields(study, frame):
        quick, slow = (_limits(ratios, times, allowed) for allowed in (GOOD_TIME, SCAN))
        if quick.max() == 0.0:
            sentences.append(f"With {name} no level of the brake lets the joint settle within {GOOD_TIME:g} s.")
            continue
        best, paper = int(np.argmax(quick)), int(np.argmin(np.abs(brakes - 1.0)))
        share = quick[paper] / quick[best]
        verdict = (
            f"the paper's {levels[paper]:.0f} % carries as much or nearly so"
            if share >= ENOUGH
            else f"the paper's {levels[paper]:.0f} % carries {100 * share:.0f} % of that"
        )
        sentences.append(
            f"With {name} a joint settles most inertia within {GOOD_TIME:g} s at {levels[best]:.0f} % of total "
            f"hysteresis, {quick[best]:.3f} kg m2 per N m; {verdict}, and without brake it carries "
            f"{_carried(quick[0])}."
        )
        late = int(np.argmax(slow))
        sentences.append(f"If {SCAN:g} s are allowed it is {levels[late]:.0f} %, with {slow[late]:.3f}.")
        moving = np.flatnonzero(np.isfinite(times).any(axis=0))
        if moving[-1] + 1 < len(levels):
            sentences.append(
                f"From {levels[moving[-1] + 1]:.0f} % on it stalls before it has arrived, whatever it carries."
            )
    return " ".join(sentences)


def _carried(limit: float) -> str:
    return f"{limit:.3f}" if limit > 0.0 else f"less than {INERTIA_PER_TORQUE:g}"
