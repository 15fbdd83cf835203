"""Curves of the experiments: what is drawn is what was given, and every quiet line says what it is."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.plot.curves import moving_average_gain, settling_over_inertia, valve_sweeps
from layflat.plot.style import GUIDE_STYLE, draw_mark, styled_figure
from tests.plot.looks import covered, cut_off, line_of, looks, units_of

SETTLING = {"new": {0.003: 0.5, 0.01: 0.7, 0.03: inf}, "earlier": {0.003: 0.9, 0.01: inf, 0.03: inf}}
COMMAND = np.linspace(-0.3, 0.3, 31)
FREQUENCY = np.linspace(1.0, 199.0, 199)


def sweeps() -> Figure:
    up, down = (COMMAND, COMMAND - 0.05), (COMMAND, COMMAND + 0.05)
    return valve_sweeps({"without": (up, down), "with": (down, up)})


def response() -> Figure:
    return moving_average_gain(FREQUENCY, np.abs(np.cos(np.pi * FREQUENCY / 100)), 50.0)


DRAWN = {"sweeps": sweeps, "settling": lambda: settling_over_inertia(SETTLING, 4.0), "response": response}


@pytest.mark.parametrize("name", DRAWN)
def test_axes_have_units_and_no_text_covers_another(name: str) -> None:
    made = DRAWN[name]()
    assert len(units_of(made)) == 2
    assert all(label.endswith(")") for label in units_of(made))
    assert covered(made) == []
    assert cut_off(made) == []


def quiet(axes: Axes) -> int:
    return sum(line.get_color() == GUIDE_STYLE["color"] for line in axes.lines)


@pytest.mark.parametrize("name", ["settling", "response"])
def test_every_quiet_line_says_what_it_is(name: str) -> None:
    (axes,) = DRAWN[name]().axes
    assert quiet(axes) == len(axes.texts) == 1


def test_settled_runs_are_joined_and_others_are_crosses_above_the_limit() -> None:
    (axes,) = settling_over_inertia(SETTLING, 4.0).axes
    x, y = line_of(axes, "new")
    assert dict(zip(x, y, strict=True)) == {0.003: 0.5, 0.01: 0.7}
    crosses = [line for line in axes.lines if line.get_marker() == "x"]
    assert [list(np.asarray(line.get_xdata())) for line in crosses] == [[0.03], [0.01, 0.03]]
    heights = [float(np.asarray(line.get_ydata())[0]) for line in crosses]
    assert min(heights) > 4.0
    assert len(set(heights)) == 2
    assert axes.get_ylim()[0] == 0.0
    assert axes.get_ylim()[1] > max(heights)


def test_both_ways_of_a_valve_look_alike_and_valves_differ() -> None:
    (axes,) = sweeps().axes
    first, back, second, _ = axes.lines
    assert first.get_linestyle() == back.get_linestyle() != second.get_linestyle()
    np.testing.assert_allclose(np.asarray(first.get_ydata()), 100 * (COMMAND - 0.05))
    assert len(set(looks(axes))) == 2


def test_response_is_in_decibels_and_a_zero_has_a_floor() -> None:
    (axes,) = response().axes
    gain = np.asarray(axes.lines[0].get_ydata(), dtype=float)
    assert np.isfinite(gain).all()
    assert gain.min() == pytest.approx(-80.0)
    assert gain[99 - 1 + 1] == pytest.approx(0.0, abs=1e-9)
    assert axes.texts[0].get_text() == "50 Hz dither"


@pytest.mark.parametrize("upright", [False, True])
def test_a_mark_is_written_beside_its_line_within_the_axes(upright: bool) -> None:
    with styled_figure() as (made, (axes,)):
        axes.set(xlim=(0.0, 2.0), ylim=(0.0, 3.0), xlabel="Time (s)", ylabel="Angle (deg)")
        draw_mark(axes, 1.2, "goal", upright=upright)
    (line,), (text,) = axes.lines, axes.texts
    values = line.get_xdata() if upright else line.get_ydata()
    assert set(np.asarray(values)) == {1.2}
    box = text.get_window_extent()
    at = axes.transData.transform((1.2, 1.2))
    assert 0 < (box.x0 - at[0] if upright else box.y0 - at[1]) < 15
    assert covered(made) == []
