"""Level of the brake and inertia of the payload: settling, and how much inertia a joint carries."""

from typing import Any

import numpy as np
import pandas
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.experiments.axis_one import LONG_SETTLING_LIMIT, SETTLING_GOAL
from layflat.experiments.bench import INERTIA_PER_TORQUE
from layflat.experiments.questions import inertia_limits, inertia_per_torque, median_grid, total_hysteresis
from layflat.plot.bars_and_maps import cell_edges, draw_map
from layflat.plot.style import styled_figure as new_figure
from layflat.study import Study

NEARLY_AS_MUCH = 0.8  # fraction of the greatest inertia that is reported as nearly as much


def _hysteresis_at(study: Study, brakes: Array) -> Array:
    """Return the total hysteresis of the paper's joint with its brake at these levels, %."""
    without, full = (total_hysteresis(study.machine, level) for level in (0.0, 1.0))
    return without + brakes * (full - without)


def _settling_maps(study: Study, frame: pandas.DataFrame) -> list[tuple[str, Array, Array, Array, Array]]:
    """Return name, brakes, hysteresis (%), inertia per torque, times to settle (inertias, brakes) of each variant."""
    maps = []
    for variant in study.variants:
        runs = frame[frame["variant"] == variant.name]
        brakes, payloads, times = median_grid(runs, "scenario.brake", "scenario.payload", "settling.small.0")
        maps.append(
            (variant.name, brakes, _hysteresis_at(study, brakes), inertia_per_torque(variant.machine, payloads), times)
        )
    return maps


def _smoothed_limits(ratios: Array, times: Array, allowed: float) -> Array:
    """Return limits after a median filter over neighbouring brakes and inertias: single fields are late by chance."""
    from scipy.ndimage import median_filter  # noqa: PLC0415  # takes long to import

    return inertia_limits(ratios, median_filter(times, size=3, mode="nearest"), allowed)


def figure(study: Study, frame: pandas.DataFrame) -> Figure:
    """Draw the settling time (s) over total hysteresis (%) and inertia per torque (kg m2 / N m), with its limits.

    Each variant of the gains has a map.
    """
    fields = _settling_maps(study, frame)
    style: dict[str, Any] = {"color": "#c23b4e", "linewidth": 2.0}
    with new_figure(1, len(fields), width=8.6, height=4.3, above=0.62) as (fig, all_axes):
        for axes, (name, _, levels, ratios, times) in zip(all_axes, fields, strict=True):
            draw_map(axes, levels, ratios, times, f"Time to settle (s), {name}", low=0.0, high=LONG_SETTLING_LIMIT)
            for allowed, dashes in ((SETTLING_GOAL, "-"), (LONG_SETTLING_LIMIT, "--")):
                limit = _smoothed_limits(ratios, times, allowed)
                shown = np.where(limit > 0.0, limit, np.nan)
                axes.plot(levels, shown, label=f"limit in {allowed:g} s", linestyle=dashes, **style)
            axes.axvline(_hysteresis_at(study, np.ones(1))[0], color="#1b1b1b", linewidth=1.0)
            axes.axhline(INERTIA_PER_TORQUE, color="#1b1b1b", linewidth=1.0, linestyle=":")
            axes.set(yscale="log", xlim=cell_edges(levels), ylim=cell_edges(ratios, log=True))
            axes.set(xlabel="Total hysteresis (%)", ylabel="Inertia per torque (kg m$^2$ per N m)")
        all_axes[0].legend(loc="upper right", fontsize=8)
    return fig


def finding(study: Study, frame: pandas.DataFrame) -> str:
    """Return text on each variant: the greatest inertia, that with the paper's brake, and where the joint stalls."""
    return " ".join(_describe_variant(*field) for field in _settling_maps(study, frame))


def _describe_variant(name: str, brakes: Array, levels: Array, ratios: Array, times: Array) -> str:
    """Return the findings about one variant of the gains in sentences.

    Args:
        name: name of the variant.
        brakes: level of the brake relative to the paper's.
        levels: total hysteresis at each level of the brake, %.
        ratios: inertia per torque, kg m2 / N m.
        times: settling time, (ratios, levels), s; infinite where not settled.
    """
    quick, slow = (_smoothed_limits(ratios, times, allowed) for allowed in (SETTLING_GOAL, LONG_SETTLING_LIMIT))
    if quick.max() == 0.0:
        return f"With {name} no level of the brake lets the joint settle within {SETTLING_GOAL:g} s."
    best, best_slow, paper = int(np.argmax(quick)), int(np.argmax(slow)), int(np.argmin(np.abs(brakes - 1.0)))
    share = quick[paper] / quick[best]
    of_best = "as much or nearly so" if share >= NEARLY_AS_MUCH else f"{100 * share:.0f} % of that"
    without_brake = f"{quick[0]:.3f}" if quick[0] > 0.0 else f"less than {INERTIA_PER_TORQUE:g}"
    text = (
        f"With {name} a joint settles most inertia within {SETTLING_GOAL:g} s at {levels[best]:.0f} % of total "
        f"hysteresis, {quick[best]:.3f} kg m2 per N m; the paper's {levels[paper]:.0f} % carries {of_best}, and "
        f"without brake it carries {without_brake}. If {LONG_SETTLING_LIMIT:g} s are allowed it is "
        f"{levels[best_slow]:.0f} %, with {slow[best_slow]:.3f}."
    )
    stalls = 1 + np.flatnonzero(np.isfinite(times).any(axis=0))[-1]
    if stalls < len(levels):
        text += f" From {levels[stalls]:.0f} % on it stalls before it has arrived, whatever it carries."
    return text
