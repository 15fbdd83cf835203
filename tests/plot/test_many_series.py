"""Figures of more series than there are colours: each has its own line."""

from collections.abc import Callable
from itertools import combinations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.plot.arms import SizedArms, sizes_figure, workspace_figure
from layflat.plot.bars_and_maps import study_figure
from layflat.plot.curves import design_figure, hysteresis_curves, settling_over_inertia, valve_sweeps
from layflat.plot.runs import angle_figure, arm_steps
from layflat.plot.style import SERIES_STYLES, series_style
from layflat.plot.tuning import RepeatErrors, learning_figure, response_figure, settled_fraction_figure

COUNT = 2 * len(SERIES_STYLES) + 2
NAMES = [f"series {i}" for i in range(COUNT)]
X = np.linspace(0.0, 1.0, 101)
RAMPS = {name: (1.0 + i) * X for i, name in enumerate(NAMES)}


def run(joints: list[str]) -> xarray.Dataset:
    """A run of these joints."""
    angles = {name: (("time", "joint"), np.tile(0.1 * X[:, None], len(joints))) for name in ("angle", "demand")}
    return xarray.Dataset(angles, {"time": X, "joint": joints})


def learning() -> Figure:
    repeats = RepeatErrors([2.0, 1.0], [3.0, 2.0], [True, True])
    return learning_figure(X, 1.0, RAMPS, RAMPS, repeats)


FIGURES: dict[str, Callable[[], Figure]] = {
    "hysteresis": lambda: hysteresis_curves(
        {name: SimpleNamespace(angle=X, torque=values) for name, values in RAMPS.items()}
    ),
    "design": lambda: design_figure({name: (X, values) for name, values in RAMPS.items()}),
    "sweeps": lambda: valve_sweeps({name: ((X, values), (X, values)) for name, values in RAMPS.items()}),
    "settling": lambda: settling_over_inertia({name: {0.1: 1.0, 0.2: np.inf} for name in NAMES}, 4.0),
    "angle": lambda: angle_figure({name: run(["a"]) for name in NAMES}, "a"),
    "arm": lambda: arm_steps(run(NAMES), band=0.005),
    "response": lambda: response_figure({name: run(["a"]) for name in NAMES}, band=0.005, since=0.0),
    "settled": lambda: settled_fraction_figure(RAMPS, None, 20.0),
    "learning": learning,
    "workspace": lambda: workspace_figure(dict.fromkeys(NAMES, np.eye(3)), np.zeros((4, 3)), ["xy"]),
    "sizes": lambda: sizes_figure([SizedArms(float(i), X, X, np.round(X)) for i in range(COUNT)], (0.5, 2.0)),
    "priced": lambda: sizes_figure([SizedArms(float(i), X, X, X, X) for i in range(COUNT)], (0.5, 2.0, 1.0)),
    "study": lambda: study_figure({"a (1)": X}, {"b (1)": X}, dict.fromkeys(NAMES, X >= 0.0)),
}


def drawn(axes: Axes) -> list[Any]:
    """Colour and dashes of all labelled lines, without guide lines and marks."""
    named = [line for line in axes.lines if not str(line.get_label()).startswith("_")]
    lines = [line for line in named if line.get_linestyle() != "None" and line.get_label() != "demand"]
    return [(line.get_color(), line._unscaled_dash_pattern) for line in lines]  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", FIGURES)
def test_every_series_has_its_own_line(name: str) -> None:
    lines = drawn(FIGURES[name]().axes[0])
    assert len(lines) == COUNT
    assert all(one != other for one, other in combinations(lines, 2))


def test_styles_differ_for_all_pairs_of_colour_and_dashes() -> None:
    styles = [series_style(order) for order in range(len(SERIES_STYLES) ** 2)]
    assert tuple(styles[: len(SERIES_STYLES)]) == SERIES_STYLES
    assert len({(style["color"], str(style["linestyle"])) for style in styles}) == len(styles)
