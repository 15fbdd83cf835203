"""Outlines of flat parts: areas, hulls and ribbons against closed forms."""

from math import cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.solids.loops import HullCircle, arc_centre, circle, hull, polygon, rectangle, ribbon, sector

SIZES = st.floats(1.0, 50.0)
PLACES = st.floats(-100.0, 100.0)


def test_areas_are_those_of_the_figures() -> None:
    assert rectangle(3.0, 4.0).area == pytest.approx(12.0)
    assert circle(1.0, 2.0, 5.0).area == pytest.approx(pi * 25.0, rel=2e-3)
    assert sector(2.0, 5.0, 0.3, 1.3).area == pytest.approx(0.5 * (25.0 - 4.0), rel=2e-3)


@given(PLACES, PLACES, SIZES, PLACES, PLACES, SIZES, st.floats(0.0, 2 * pi))
def test_a_hull_holds_its_circles_and_touches_them(
    x: float, y: float, r: float, u: float, v: float, s: float, angle: float
) -> None:
    if hypot(u - x, v - y) <= abs(r - s) + 1.0:
        return
    points = hull([HullCircle(x, y, r), HullCircle(u, v, s)]).points()
    way = np.array([cos(angle), sin(angle)])
    reach = max(x * way[0] + y * way[1] + r, u * way[0] + v * way[1] + s)
    found = float((points @ way).max())
    assert reach - 1.0 - 0.01 * max(r, s) <= found <= reach + 1e-6 * (1 + abs(reach))


def test_a_hull_of_two_equal_circles_is_a_stadium() -> None:
    loop = hull([HullCircle(0.0, 0.0, 2.0), HullCircle(10.0, 0.0, 2.0)])
    assert loop.area == pytest.approx(40.0 + pi * 4.0, rel=2e-3)


def test_a_circle_inside_another_is_left_out() -> None:
    assert hull([HullCircle(0.0, 0.0, 5.0), HullCircle(1.0, 0.0, 1.0)]).area == pytest.approx(25 * pi, rel=2e-3)


def test_a_ribbon_keeps_its_thickness_around_corners() -> None:
    path = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    points = ribbon(path, 0.5, 0.5).points()
    corner = points[np.argmax(points @ [1.0, -1.0])]
    assert corner == pytest.approx([10.5, -0.5])


def test_the_centre_of_an_arc_is_as_far_from_all_its_points() -> None:
    x, y = arc_centre((3.0, 0.0), (3.0 / sqrt(2.0), 3.0 / sqrt(2.0)), (0.0, 3.0))
    assert hypot(x, y) == pytest.approx(0.0, abs=1e-9)


def test_turning_and_mirroring_keep_the_area() -> None:
    loop = polygon([(0, 0), (4, 0), (1, 3)])
    assert loop.turned(1.0, (2.0, 5.0)).area == pytest.approx(loop.area)
    assert loop.mirrored().points()[:, 0] == pytest.approx(-loop.points()[:, 0])


def test_distances_go_to_sides_corners_and_arcs() -> None:
    plate = rectangle(4.0, 2.0)
    assert plate.distance((0.0, 0.0)) == pytest.approx(1.0)
    assert plate.distance((5.0, 5.0)) == pytest.approx(5.0)
    ring = circle(1.0, 2.0, 30.0)
    assert ring.distance((1.0 + 29.0 * cos(0.7), 2.0 + 29.0 * sin(0.7))) == pytest.approx(1.0, abs=1e-12)


@given(st.floats(-40.0, 40.0), st.floats(-40.0, 40.0), st.floats(0.0, 6.0))
def test_distances_are_those_of_many_points_on_the_outline(x: float, y: float, turn: float) -> None:
    figure = sector(10.0, 20.0, 0.2, 3.0).turned(turn, (1.0, 2.0))
    for one in (figure, figure.mirrored()):
        many = one.points(step=1e-3)
        dense = np.vstack([many + share * (np.roll(many, -1, axis=0) - many) for share in np.linspace(0.0, 1.0, 60)])
        assert one.distance((x, y)) == pytest.approx(float(np.hypot(*(dense - (x, y)).T).min()), abs=0.1)
