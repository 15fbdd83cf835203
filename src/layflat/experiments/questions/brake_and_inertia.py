"""Level of the brake and inertia of the payload: settling, and how much inertia a joint carries."""

from typing import Any

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.axis_one import GOOD_TIME, SCAN
from layflat.experiments.bench import INERTIA_PER_TORQUE
from layflat.experiments.questions.tables import grid, hysteresis, inertia_per_torque, limits
from layflat.plot.bars_and_maps import draw_map, edges
from layflat.plot.style import figure as new_figure
from layflat.study import Study

ENOUGH = 0.8  # what carries this share of the most carries nearly as much


def _levels(study: Study, brakes: Array) -> Array:
    """Total hysteresis, %, of the paper's joint with its brake at these levels."""
    without, full = (hysteresis(study.machine, level) for level in (0.0, 1.0))
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
    """Draw a map for each variant of the gains."""
    fields = _fields(study, frame)
    style: dict[str, Any] = {"color": "#c23b4e", "linewidth": 2.0}
    with new_figure(1, len(fields), width=8.6, height=4.3, above=0.62) as (made, all_axes):
        for axes, (name, _, levels, ratios, times) in zip(all_axes, fields, strict=True):
            draw_map(axes, levels, ratios, times, f"Time to settle (s), {name}", low=0.0, high=SCAN)
            for allowed, dashes in ((GOOD_TIME, "-"), (SCAN, "--")):
                limit = _limits(ratios, times, allowed)
                shown = np.where(limit > 0.0, limit, np.nan)
                axes.plot(levels, shown, label=f"limit in {allowed:g} s", linestyle=dashes, **style)
            axes.axvline(_levels(study, np.ones(1))[0], color="#1b1b1b", linewidth=1.0)
            axes.axhline(INERTIA_PER_TORQUE, color="#1b1b1b", linewidth=1.0, linestyle=":")
            axes.set(yscale="log", xlim=edges(levels), ylim=edges(ratios, log=True))
            axes.set(xlabel="Total hysteresis (%)", ylabel="Inertia per torque (kg m$^2$ per N m)")
        all_axes[0].legend(loc="upper right", fontsize=8)
    return made


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Say where each variant carries most, what the paper's brake carries, and where the joint stalls."""
    return " ".join(_found(*field) for field in _fields(study, frame))


def _found(name: str, brakes: Array, levels: Array, ratios: Array, times: Array) -> str:
    quick, slow = (_limits(ratios, times, allowed) for allowed in (GOOD_TIME, SCAN))
    if quick.max() == 0.0:
        return f"With {name} no level of the brake lets the joint settle within {GOOD_TIME:g} s."
    best, late, paper = int(np.argmax(quick)), int(np.argmax(slow)), int(np.argmin(np.abs(brakes - 1.0)))
    share = quick[paper] / quick[best]
    most = "as much or nearly so" if share >= ENOUGH else f"{100 * share:.0f} % of that"
    least = f"{quick[0]:.3f}" if quick[0] > 0.0 else f"less than {INERTIA_PER_TORQUE:g}"
    said = (
        f"With {name} a joint settles most inertia within {GOOD_TIME:g} s at {levels[best]:.0f} % of total "
        f"hysteresis, {quick[best]:.3f} kg m2 per N m; the paper's {levels[paper]:.0f} % carries {most}, and without "
        f"brake it carries {least}. If {SCAN:g} s are allowed it is {levels[late]:.0f} %, with {slow[late]:.3f}."
    )
    stalls = 1 + np.flatnonzero(np.isfinite(times).any(axis=0))[-1]
    if stalls < len(levels):
        said += f" From {levels[stalls]:.0f} % on it stalls before it has arrived, whatever it carries."
    return said
