from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell.geometry import outlines_overlap, rectangle_corners

spots = st.tuples(st.floats(-1, 1), st.floats(-1, 1))
sizes = st.tuples(st.floats(0.05, 0.6), st.floats(0.05, 0.6))
turns = st.floats(-3, 3)


@given(spots, turns, sizes, spots, turns, sizes)
def test_overlap_agrees_with_points_inside(
    one: tuple[float, float],
    turn: float,
    size: tuple[float, float],
    other: tuple[float, float],
    turned: float,
    extent: tuple[float, float],
) -> None:
    first, second = rectangle_corners(one, turn, size), rectangle_corners(other, turned, extent)
    assert outlines_overlap(first, second) == outlines_overlap(second, first)
    grid = np.stack(np.meshgrid(np.linspace(-0.49, 0.49, 12), np.linspace(-0.49, 0.49, 12)), axis=-1).reshape(-1, 2)
    cos, sin = np.cos(turn), np.sin(turn)
    inside = (grid * size) @ np.array([[cos, sin], [-sin, cos]]) + np.array(one)
    back = (inside - np.array(other)) @ np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
    if (np.abs(back) < np.array(extent) / 2).all(axis=1).any():
        assert outlines_overlap(first, second)
