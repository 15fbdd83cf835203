"""Line drawings show what the eye sees: edges in front, none behind; lines keep their ends as they become paths."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.solids.line_drawing import BALLOON_RADIUS, DrawnBody, _path, _spread, draw, find_lines, prepare
from layflat.solids.loops import rectangle
from layflat.solids.shapes import Prism, place

ENDS = st.tuples(st.integers(0, 6), st.integers(0, 6))


@given(st.lists(st.tuples(ENDS, ENDS), max_size=30))
def test_a_path_draws_each_line_once(lines: list[tuple[tuple[int, int], tuple[int, int]]]) -> None:
    exact = [((float(a), float(b)), (float(c), float(d))) for (a, b), (c, d) in lines]
    drawn = []
    for chain in _path(np.array(exact).reshape(-1, 2, 2)).split("M")[1:]:
        steps = np.array(re.findall(r"-?\d+", chain), float).reshape(-1, 2)
        values = np.cumsum(steps, axis=0) / 10.0
        drawn += [frozenset(map(tuple, pair)) for pair in zip(values.tolist(), values[1:].tolist(), strict=False)]
    expected = {frozenset(line) for line in exact if line[0] != line[1]}
    assert set(drawn) == expected


@given(st.lists(st.floats(0.0, 700.0), min_size=1, max_size=15))
def test_balloons_of_a_column_do_not_touch_and_stay_inside(heights: list[float]) -> None:
    found = _spread(sorted(heights), 700.0)
    assert (np.diff(found) >= 2 * BALLOON_RADIUS + 3.9).all()
    assert found.min() >= BALLOON_RADIUS
    assert found.max() <= 700.0 - BALLOON_RADIUS


def boxes(*at: tuple[float, float, float]) -> list[DrawnBody]:
    pytest.importorskip("OCP")
    from layflat.solids import cad
    from layflat.solids.kernel import placed

    solid = cad.solid(Prism(rectangle(10.0, 10.0), 10.0))
    prepare(solid)
    return [DrawnBody(placed(solid, place(*one)), number) for number, one in enumerate(at, 1)]


def test_a_box_shows_nine_edges_and_a_box_behind_it_none() -> None:
    near, far = boxes((0.0, 0.0, 0.0), (-20.0, -20.0, -20.0))
    find_lines([near, far], (1.0, 1.0, 1.0))
    assert len(near.lines) == 9
    assert far.lines == []
    low, high = np.array(near.lines).min(axis=(0, 1)), np.array(near.lines).max(axis=(0, 1))
    assert high - low == pytest.approx([10 * np.sqrt(2), 10 * np.sqrt(8 / 3)], rel=1e-6)


def test_a_drawing_is_an_svg_with_a_balloon_for_each_number() -> None:
    bodies = boxes((0.0, 0.0, 0.0), (30.0, 0.0, 0.0), (0.0, 40.0, 0.0))
    bodies[2].number, bodies[2].faint = 0, True
    find_lines(bodies, (1.0, 1.0, 1.0))
    svg = draw(bodies, "Boxes")
    tree = ElementTree.fromstring(svg)
    space = "{http://www.w3.org/2000/svg}"
    assert {text.text for text in tree.iter(f"{space}text")} == {"1", "2"}
    assert tree.find(f"{space}title").text == "Boxes"  # type: ignore[union-attr]
    width, height = map(float, tree.attrib["viewBox"].split()[2:])
    for x, y in re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)"', svg):
        assert 0 < float(x) < width
        assert 0 < float(y) < height
