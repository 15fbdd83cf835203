"""Sheets as SVG: to scale, whole, readable from below or the right, and with words of any kind."""

from __future__ import annotations

from math import cos, radians, sin
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.design.sheet import Circle, Diameter, Distance, Note, Polyline, Sheet, svg_text

SVG = "{http://www.w3.org/2000/svg}"
numbers = st.floats(-200.0, 200.0)
points = st.tuples(numbers, numbers)


def parsed(sheet: Sheet) -> ElementTree.Element:
    return ElementTree.fromstring(svg_text(sheet))


def corners(root: ElementTree.Element) -> tuple[np.ndarray, np.ndarray]:
    left, top, width, height = (float(value) for value in root.attrib["viewBox"].split())
    return np.array([left, -top - height]), np.array([left + width, -top])


@given(line=st.lists(points, min_size=2, max_size=6), centre=points, radius=st.floats(0.1, 80.0), at=points)
def test_the_picture_holds_everything_that_is_drawn(
    line: list[tuple[float, float]], centre: tuple[float, float], radius: float, at: tuple[float, float]
) -> None:
    sheet = Sheet("a sheet", 3.0)
    sheet.paths.append(Polyline(np.array(line), "STRAP"))
    sheet.circles.append(Circle(centre, radius, "OUTLINE"))
    sheet.notes.append(Note(at, "a note"))
    root = parsed(sheet)
    low, high = corners(root)
    drawn = np.vstack([line, np.array(centre) - radius, np.array(centre) + radius, at])
    assert (drawn >= low).all()
    assert (drawn <= high).all()
    sizes = [float(root.attrib[side].removesuffix("mm")) for side in ("width", "height")]
    assert sizes == pytest.approx(high - low, abs=2e-3)


@given(direction=st.floats(-360.0, 360.0), length=st.floats(5.0, 100.0), aside=st.floats(-40.0, 40.0))
def test_a_dimension_is_as_long_as_what_it_measures_and_never_upside_down(
    direction: float, length: float, aside: float
) -> None:
    along = np.array([cos(radians(direction)), sin(radians(direction))])
    across = np.array([-along[1], along[0]])
    base = tuple(aside * across)
    last = tuple(length * along + 7.0 * across)
    distance = Distance((0.0, 0.0), (last[0], last[1]), (base[0], base[1]), direction, f"{length:.1f}")
    ends = distance.ends
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(length)
    np.testing.assert_allclose(ends @ across, [aside, aside], atol=1e-9)
    sheet = Sheet("a sheet", 3.0, distances=[distance])
    root = parsed(sheet)
    tips = [arrow.attrib["points"].split()[0] for arrow in root.iter(f"{SVG}polygon")]
    drawn = np.array([[float(value) for value in tip.split(",")] for tip in tips]) * [1, -1]
    np.testing.assert_allclose(drawn[np.lexsort(drawn.T)], ends[np.lexsort(ends.round(4).T)], atol=1e-3)
    (text,) = root.iter(f"{SVG}text")
    turned = -float(text.attrib["transform"].removeprefix("rotate(").split()[0])
    assert -90.0 < turned <= 90.0 + 1e-3
    assert (turned - direction) % 180.0 == pytest.approx(0.0, abs=1e-3) or (turned - direction) % 180.0 > 179.99


@given(direction=st.floats(0.0, 360.0))
def test_a_diameter_points_at_the_rim_and_its_text_lies_outside(direction: float) -> None:
    root = parsed(Sheet("a sheet", 3.0, diameters=[Diameter((10.0, 5.0), 20.0, direction, "⌀40", 30.0)]))
    (arrow,) = root.iter(f"{SVG}polygon")
    x, y = (float(value) for value in arrow.attrib["points"].split()[0].split(","))
    assert np.hypot(x - 10.0, -y - 5.0) == pytest.approx(20.0, abs=1e-3)
    (text,) = root.iter(f"{SVG}text")
    first = np.array([float(text.attrib["x"]), -float(text.attrib["y"])]) - [10.0, 5.0]
    assert np.hypot(*first) > 20.0


def test_words_may_hold_anything() -> None:
    text = 'a < b & "c" > d, ⌀ 5 °'
    root = parsed(Sheet(text, 3.0, notes=[Note((0.0, 0.0), text)]))
    assert [element.text for element in root.iter(f"{SVG}text")] == [text]
    title = root.find(f"{SVG}title")
    assert title is not None
    assert title.text == text
