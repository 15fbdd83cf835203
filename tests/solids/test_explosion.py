"""Parts of an exploded view move along their directions until they are clear of one another."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.solids.component import Component, axes_towards
from layflat.solids.explosion import Moving, corners, explode
from layflat.solids.loops import rectangle
from layflat.solids.shapes import PartPlace, Prism, place

SIZES = st.floats(1.0, 30.0)


def cube(name: str, size: float, *places: PartPlace) -> Component:
    return Component(name, "body", Prism(rectangle(size, size), size), "aluminium", "milling", places)


@given(st.lists(SIZES, min_size=1, max_size=5), st.sampled_from(["+z", "-z", "+y", "-y"]))
def test_a_stack_comes_apart_in_its_order(sizes: list[float], direction: str) -> None:
    base = cube("base", 10.0, place())
    moving = [Moving(cube(f"{k}", size, place()), direction) for k, size in enumerate(sizes)]  # type: ignore[arg-type]
    axis, sign = "xyz".index(direction[1]), 1.0 if direction[0] == "+" else -1.0
    last = sign * corners(base.shape, place())[:, axis]
    for one, (at,) in zip(moving, explode([base], moving), strict=True):
        found = sign * corners(one.component.shape, at)[:, axis]
        assert found.min() > last.max()
        others = [k for k in range(3) if k != axis]
        assert at.origin[others].tolist() == [0.0, 0.0]
        last = found


def test_what_lies_beside_a_path_is_in_nobodys_way() -> None:
    aside = cube("aside", 10.0, place(50.0, 0.0, 40.0))
    base = cube("base", 10.0, place())
    moved = [
        explode(there, [Moving(cube("a", 4.0, place()), "+z")])[0][0].origin[2] for there in ([base], [base, aside])
    ]
    assert moved[1] > moved[0] > 10.0  # the whole picture is larger, and with it the gap
    assert moved[1] < 25.0


def test_heads_point_where_screws_come_from_and_a_side_is_that_of_each_part() -> None:
    outward = np.array([0.6, 0.8, 0.0])
    at = PartPlace(axes_towards(*outward), np.zeros(3))
    block = cube("block", 20.0, place(0.0, 0.0, -10.0))
    (head,), (left, right) = explode(
        [block], [Moving(cube("screw", 2.0, at), "head"), Moving(cube("plate", 2.0, place(-12.0), place(12.0)), "side")]
    )
    assert np.cross(head.origin, outward) == pytest.approx(np.zeros(3), abs=1e-9)
    assert head.origin @ outward > 10.0
    assert left.origin[0] < -12.0 < 12.0 < right.origin[0]


def test_a_leader_takes_followers_along_and_a_block_moves_as_one() -> None:
    base, bar, screw = cube("base", 20.0, place()), cube("bar", 4.0, place()), cube("screw", 1.0, place(0.0, 0.0, 1.0))
    (up,), (with_bar,) = explode([base], [Moving(bar, "+z"), Moving(screw, "-y", follows="bar")])
    assert with_bar.origin[2] == pytest.approx(1.0 + up.origin[2])
    (a,), (b,) = explode([base], [Moving(bar, "+z", block="x"), Moving(screw, "+z", block="x")])
    assert b.origin - a.origin == pytest.approx(np.array([0.0, 0.0, 1.0]))
