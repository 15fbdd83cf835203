"""Bars and maps: each value at its place, told apart without colour, and hatched where there is none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle

from layflat.plot.bars_and_maps import BAR_HATCHES, NO_VALUE_STYLE, cell_edges, draw_bars, draw_map
from layflat.plot.style import styled_figure
from tests.plot.looks import boxes, covered, cut_off

NAMES = ["dither", "supply", "payload", "brake"]
VALUES = [0.9, 0.5, 0.2, 0.0]


def test_bars_are_as_long_as_their_values_with_the_first_on_top() -> None:
    with styled_figure(beside=0.3) as (made, (axes,)):
        draw_bars(axes, NAMES, VALUES, form="{:.1f}")
    bars = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    assert [bar.get_width() for bar in bars] == VALUES
    heights = axes.transData.transform([(0.0, bar.get_y()) for bar in bars])[:, 1]
    assert (np.diff(heights) < 0).all()
    assert [text.get_text() for text in axes.texts] == ["0.9", "0.5", "0.2", "0.0"]
    assert [label.get_text() for label in axes.get_yticklabels()] == NAMES
    assert covered(made) == []
    assert cut_off(made) == []


def test_kinds_of_bars_differ_in_hatch() -> None:
    with styled_figure() as (_, (axes,)):
        draw_bars(axes, [], VALUES, kinds=[0, 1, 2, 3])
    assert len({patch.get_hatch() for patch in axes.patches}) == len(BAR_HATCHES) == len(set(BAR_HATCHES))
    assert [label.get_text() for label in axes.get_yticklabels()] == [""] * 4


def test_values_stand_beyond_the_intervals_and_within_the_axes() -> None:
    ends = [(0.6, 1.4), (0.4, 0.5), (0.1, 0.3), (0.0, 0.0)]
    with styled_figure(beside=0.3) as (made, (axes,)):
        draw_bars(axes, NAMES, VALUES, ends=ends, form="{:.3f}")
    assert axes.get_xlim()[1] > 1.4
    placed = dict(boxes(made))
    for text, value, (_, high) in zip(axes.texts, VALUES, ends, strict=True):
        end = axes.transData.transform((max(value, high), 0.0))[0]
        assert placed[text.get_text()].x0 >= end
    assert cut_off(made) == []


def test_bars_of_nothing_but_zeros_have_an_axis() -> None:
    with styled_figure() as (_, (axes,)):
        draw_bars(axes, ["a"], [0.0])
    assert axes.get_xlim() == (0.0, 1.0)


def test_a_map_shows_each_value_at_its_place_and_none_as_hatched_ground() -> None:
    x, y = np.arange(4.0), np.arange(3.0)
    z = np.arange(12.0).reshape(3, 4)
    z[1, 2], z[2, 0] = np.nan, np.inf
    with styled_figure(above=0.7) as (made, (axes,)):
        draw_map(axes, x, y, z, "Time to settle (s)", low=0.0, high=8.0)
        axes.set(xlabel="Inertia (kg m$^2$)", ylabel="Brake (N m)")
    (mesh,) = [part for part in axes.collections if isinstance(part, QuadMesh)]
    shown: Any = np.ma.asarray(mesh.get_array()).reshape(3, 4)
    np.testing.assert_array_equal(np.ma.getmaskarray(shown), ~np.isfinite(z))
    np.testing.assert_array_equal(shown.compressed(), z[np.isfinite(z)])
    assert mesh.get_clim() == (0.0, 8.0)
    assert axes.patch.get_hatch() == NO_VALUE_STYLE["hatch"]
    assert covered(made) == []
    assert cut_off(made) == []
    (scale,) = axes.child_axes
    assert scale.get_xlabel() == "Time to settle (s)"


def test_more_is_darker_on_a_map() -> None:
    with styled_figure(above=0.7) as (_, (axes,)):
        draw_map(axes, np.arange(5.0), np.arange(2.0), np.tile(np.arange(5.0), (2, 1)), "Time (s)", low=0.0, high=4.0)
    mesh = axes.collections[0]
    assert isinstance(mesh, QuadMesh)
    colours = np.asarray(mesh.to_rgba(np.arange(5.0)))[:, :3]
    light = colours @ np.array([0.299, 0.587, 0.114])
    assert (np.diff(light) < 0).all()
    assert to_hex(colours[0]) != NO_VALUE_STYLE["facecolor"]


@pytest.mark.parametrize("log", [False, True])
def test_edges_lie_half_a_field_beyond_the_points(log: bool) -> None:
    points = np.geomspace(1.0, 8.0, 4) if log else np.linspace(1.0, 7.0, 4)
    low, high = cell_edges(points, log=log)
    assert (low, high) == pytest.approx((2**-0.5, 8 * 2**0.5) if log else (0.0, 8.0))
