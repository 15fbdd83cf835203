"""Blanks have the sizes of their shapes, and lists of cuts all that is cut to length."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.solids.blanks import KERF_WIDTH, blank_size, extents, list_cuts, outer_points, strip_length
from layflat.solids.loops import circle, rectangle, ribbon, sector
from layflat.solids.shapes import Lofted, Prism, Turned
from tests.solids.joints import components_of

SMALL = components_of("paper-arm", "small")


@given(st.floats(10.0, 100.0), st.floats(0.2, 2.5), st.floats(0.1, 3.0))
def test_a_bent_strip_is_as_long_as_its_middle(radius: float, angle: float, thickness: float) -> None:
    loop = sector(radius - thickness / 2, radius + thickness / 2, 0.3, 0.3 + angle)
    length = max(radius * angle, thickness)  # the longer side of a short one is its thickness
    assert strip_length(loop) == pytest.approx(max(length, min(radius * angle, thickness)), rel=5e-3)


@given(st.floats(1.0, 100.0), st.floats(1.0, 100.0), st.floats(0.0, pi))
def test_a_turned_rectangle_has_its_own_sizes(width: float, height: float, angle: float) -> None:
    x, y, z = extents(Prism(rectangle(width, height, (3.0, -7.0)).turned(angle), 5.0))
    assert sorted((x, y)) == pytest.approx(sorted((width, height)), rel=1e-9)
    assert z == 5.0


def test_the_box_of_each_kind_of_shape() -> None:
    def box(shape: Prism | Turned | Lofted) -> list[list[float]]:
        points = outer_points(shape)
        return [points.min(axis=0).tolist(), points.max(axis=0).tolist()]

    assert box(Prism(rectangle(2.0, 4.0), 3.0)) == [[-1.0, -2.0, 0.0], [1.0, 2.0, 3.0]]
    assert box(Turned(rectangle(1.0, 6.0, (4.5, 2.0)))) == [[-5.0, -5.0, -1.0], [5.0, 5.0, 5.0]]
    assert box(Lofted((((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 0, 2), (1, 0, 2), (0, 1, 2))))) == [[0, 0, 0], [1, 1, 2]]


def test_the_blank_of_a_bent_sheet_is_flat_and_that_of_a_turned_part_round() -> None:
    angles = np.linspace(0.0, 1.0, 60)
    path = 50.0 * np.array([[cos(a), sin(a)] for a in angles])
    shell = next(one for one in SMALL if one.name == "shell A")
    assert blank_size(replace(shell, shape=Prism(ribbon(path, 0.5, 0.5), 70.0))) == "50 x 70"
    shaft = next(one for one in SMALL if one.name == "shaft")
    assert blank_size(shaft).startswith("dia 10 x ")
    disc = replace(shaft, shape=Prism(circle(0.0, 0.0, 20.0), 3.0))
    assert blank_size(disc) == "40 x 40 x 3"


def test_every_length_is_cut_and_enough_is_bought() -> None:
    cuts = {cut.stock: cut for cut in list_cuts([*SMALL, *components_of("paper-arm", "large")])}
    for cut in cuts.values():
        lengths = sum(length * number for _, length, number in cut.pieces)
        pieces = sum(number for _, _, number in cut.pieces)
        assert cut.total >= lengths
        assert cut.total == pytest.approx(lengths + cut.loss * pieces, abs=1.0)
    rods = [one for one in SMALL if one.designation.startswith("DIN 976-1 M5")]
    assert {name for name, _, _ in cuts["DIN 976-1 M5 - A2-70"].pieces} == {one.name for one in rods}
    hose = cuts["layflat hose 110"]
    assert hose.loss == 0.0
    assert cuts["round bar 12"].loss == KERF_WIDTH
    assert [f"{length:.0f} mm long" for _, length, _ in hose.pieces] == [
        one.size for one in SMALL if "hose" in one.tags
    ]


def test_a_strap_is_cut_once_for_each_of_its_layers() -> None:
    strap = next(one for one in SMALL if one.name == "strap of hose B")
    assert strap.designation.endswith("2 layers")
    ((_, _, number),) = list_cuts([strap])[0].pieces
    assert number == 2 * strap.quantity
