from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell.file.checks import overlap, reachable, rectangle
from layflat.machine import load

ARM = load("paper-arm")
spots = st.tuples(st.floats(-1, 1), st.floats(-1, 1))
sizes = st.tuples(st.floats(0.05, 0.6), st.floats(0.05, 0.6))
turns = st.floats(-3, 3)


def tip(q_1: float, q_2: float) -> tuple[float, float]:
    """Of the paper's arm, by complex numbers."""
    at = 0.4 * np.exp(1j * q_1) * (1 + np.exp(1j * (q_2 + np.pi / 2)))
    return float(at.real), float(at.imag)


@given(st.floats(-2.2, 2.2), st.floats(-2.2, 2.2))
def test_what_the_arm_reaches_is_where_its_tip_comes(q_1: float, q_2: float) -> None:
    limit = np.pi / 3
    if max(abs(q_1), abs(q_2)) < limit - 1e-6:
        assert reachable(ARM, np.array([tip(q_1, q_2)]))[0]


def test_nothing_else_is_reached() -> None:
    q = np.linspace(-np.pi / 3, np.pi / 3, 161)
    at = 0.4 * np.exp(1j * q[:, None]) * (1 + np.exp(1j * (q[None, :] + np.pi / 2)))
    rng = np.random.default_rng(0)
    for x, y in rng.uniform(-0.85, 0.85, (200, 2)):
        if np.abs(at - (x + 1j * y)).min() > 1e-2:
            assert not reachable(ARM, np.array([[x, y]]))[0]


@given(spots, turns, sizes, spots, turns, sizes)
def test_overlap_agrees_with_points_inside(
    one: tuple[float, float],
    turn: float,
    size: tuple[float, float],
    other: tuple[float, float],
    turned: float,
    extent: tuple[float, float],
) -> None:
    first, second = rectangle(one, turn, size), rectangle(other, turned, extent)
    assert overlap(first, second) == overlap(second, first)
    grid = np.stack(np.meshgrid(np.linspace(-0.49, 0.49, 12), np.linspace(-0.49, 0.49, 12)), axis=-1).reshape(-1, 2)
    cos, sin = np.cos(turn), np.sin(turn)
    inside = (grid * size) @ np.array([[cos, sin], [-sin, cos]]) + np.array(one)
    back = (inside - np.array(other)) @ np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
    if (np.abs(back) < np.array(extent) / 2).all(axis=1).any():
        assert overlap(first, second)
