"""Figures: units on the axes, the same bytes for the same data, no pyplot."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import OutputError
from layflat.machine import load
from layflat.plot.curves import hysteresis_curves
from layflat.plot.runs import angle_figure, arm_steps, run_figure
from layflat.plot.style import SERIES_STYLES, save_figure, styled_figure, to_svg
from layflat.sim import rollout
from layflat.sim.sweep import sweep


@pytest.fixture(scope="module")
def run():  # type: ignore[no-untyped-def]
    return rollout("paper-arm", "10 deg", start=0.0, duration=0.5)


def test_every_axis_of_a_run_has_its_unit(run) -> None:  # type: ignore[no-untyped-def]
    for made in (run_figure(run), angle_figure({"a": run}, "small", band=0.005), arm_steps(run, band=0.005)):
        labels = [text for axes in made.axes for text in (axes.get_ylabel(),)]
        assert all(label.endswith(")") for label in labels)
        assert any("(s)" in axes.get_xlabel() for axes in made.axes)


def test_a_loop_is_drawn_closed_with_units() -> None:
    made = hysteresis_curves({"new": sweep(load("paper-arm"), "small", 4e5)})
    (axes,) = made.axes
    assert "(deg)" in axes.get_xlabel()
    assert "(N m)" in axes.get_ylabel()
    x = np.asarray(axes.lines[0].get_xdata())
    assert x[0] == x[-1]


def test_the_same_data_give_the_same_bytes(run) -> None:  # type: ignore[no-untyped-def]
    assert to_svg(run_figure(run)) == to_svg(run_figure(run))


def test_lines_differ_in_dash_and_in_lightness() -> None:
    from matplotlib.colors import to_rgb

    light = [float(np.dot(to_rgb(line["color"]), (0.299, 0.587, 0.114))) for line in SERIES_STYLES]
    assert len({str(line["linestyle"]) for line in SERIES_STYLES}) == len(SERIES_STYLES)
    assert light[:4] == sorted(light[:4])


def test_matplotlib_is_imported_where_figures_are_drawn_and_pyplot_never() -> None:
    code = (
        "import sys; from layflat import cli, design, identify, rig, sim, study, tune\n"
        "print('matplotlib' in sys.modules)\n"
        "from layflat.plot import style\n"
        "with style.styled_figure() as (made, _): style.to_svg(made)\n"
        "print('matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


def test_a_figure_that_can_not_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with styled_figure() as (made, _), pytest.raises(OutputError):
        save_figure(made, tmp_path / "file" / "x.png")


def test_the_suffix_says_how_a_figure_is_written(tmp_path: Path) -> None:
    with styled_figure() as (made, _):
        assert save_figure(made, tmp_path / "x.png").read_bytes()[:4] == b"\x89PNG"
        assert save_figure(made, tmp_path / "x.pdf").read_bytes()[:4] == b"%PDF"
