"""Flat patterns: lengths, bends and holes of bent parts, against sheets bent by hand."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.solids.component import Component
from layflat.solids.drawings.flat import cut_by_contour, cut_length, flat_part
from layflat.solids.loops import circle, rectangle, ribbon
from layflat.solids.shapes import Drilled, Hole, Prism
from tests.solids.drawings.parts import component, joint_parts, made_parts

BENT = [one for one in made_parts() if one.making == "bending"]


def bent_sheet(radius: float, angle: float, thickness: float, leg: float, step: float) -> Prism:
    """Return a sheet with two straight legs and one bend to the left, of a radius in its middle."""
    angles = np.linspace(-pi / 2, angle - pi / 2, max(3, int(angle / step)))
    arc = np.stack((radius * np.cos(angles), radius + radius * np.sin(angles)), axis=-1)
    last = arc[-1] + leg * np.array([cos(angle), sin(angle)])
    return Prism(ribbon(np.vstack(([-leg, 0.0], arc, last)), thickness / 2, thickness / 2), 40.0)


@given(st.floats(10, 80), st.floats(0.5, 2.5), st.floats(0.5, 3), st.floats(10, 60))
def test_the_pattern_of_one_bend_has_its_length_radius_and_angle(r: float, angle: float, t: float, leg: float) -> None:
    part = flat_part(component(bent_sheet(r, angle, t, leg, 0.05), "bending", "aluminium-sheet"))
    assert part is not None
    assert part.box[1] == pytest.approx([2 * leg + r * angle, 40.0], rel=2e-3)
    assert part.thickness == pytest.approx(t, rel=1e-2)
    (bend,) = part.bends
    assert bend.radius + t / 2 == pytest.approx(r, rel=0.02)
    assert bend.angle == pytest.approx(-angle, rel=0.05)  # the line turns left, away from who looks at its right side
    assert (bend.start, bend.end) == pytest.approx((leg, leg + r * angle), abs=0.01 * r * angle)


def test_a_corner_is_a_bend_with_the_smallest_radius_of_its_material() -> None:
    corner = Prism(ribbon(np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 20.0]]), 1.0, 1.0), 40.0)
    part = flat_part(component(corner, "bending", "aluminium-sheet"))
    assert part is not None
    (bend,) = part.bends
    assert bend.radius == pytest.approx(1.5 * part.thickness)
    assert abs(bend.angle) == pytest.approx(pi / 2)
    assert (bend.start + bend.end) / 2 == pytest.approx(30.0)


@pytest.mark.parametrize("one", BENT, ids=lambda one: one.name)
def test_a_pattern_has_the_area_of_the_bent_sheet(one: Component) -> None:
    part = flat_part(one)
    assert part is not None
    assert isinstance(one.shape, Prism)
    assert part.outline.area * part.thickness == pytest.approx(one.shape.outline.area * one.shape.height, rel=0.01)
    assert part.bends


def test_a_hole_through_a_bent_sheet_lies_where_its_axis_crosses_the_middle() -> None:
    r, t, leg = 50.0, 2.0, 20.0
    for angle in (0.2, 0.7, 1.1):
        out = np.array([sin(angle), -cos(angle)])
        start = np.array([0.0, r]) + (r + t) * out
        hole = Drilled((start[0], start[1], 12.0), (-out[0], -out[1], 0.0), 4.2, 2 * t, "M5")
        shape = bent_sheet(r, 1.3, t, leg, 0.02)
        part = flat_part(component(Prism(shape.outline, 40.0, drilled=(hole,)), "bending", "aluminium-sheet"))
        assert part is not None
        (found,) = part.holes
        assert found.centre == pytest.approx((leg + r * angle, 12.0), abs=0.02)
        assert (found.diameter, found.thread) == (4.2, "M5")


def test_a_plate_is_its_own_pattern() -> None:
    shape = Prism(circle(0, 0, 30), 5.0, (Hole((10.0, 0.0), 5.5),), (rectangle(4, 4),))
    part = flat_part(component(shape))
    assert part is not None
    assert (part.outline, part.holes, part.openings, part.thickness) == (shape.outline, shape.holes, shape.openings, 5)
    assert not part.bends


def test_hoses_and_straps_have_the_length_that_the_list_says() -> None:
    for one in made_parts():
        part = flat_part(one)
        if part is not None and one.making == "cutting" and cut_length(one) is not None:
            assert part.box[1, 0] == pytest.approx(cut_length(one), abs=0.06)
            assert len(part.holes) >= 1


def test_a_hose_is_as_wide_as_its_designation_says() -> None:
    for one in joint_parts():
        if one.material == "hose":
            part = flat_part(one)
            assert part is not None
            assert part.box[1, 1] == pytest.approx(float(one.designation.split()[-1]), abs=0.1)


def test_tubes_and_turned_parts_have_no_contour_to_cut() -> None:
    cut = {one.name for one in made_parts() if cut_by_contour(one, flat_part(one))}
    assert {"arm plate", "shell A", "hose A"} <= cut
    assert not cut & {"cylinder", "shaft", "brake disc"}


def test_a_hole_across_a_tube_ends_at_the_inner_wall_and_a_blind_one_keeps_its_depth() -> None:
    out = Drilled((-31.0, 0.0, 20.0), (1.0, 0.0, 0.0), 5.4, 12.0)
    part = flat_part(component(Prism(circle(0, 0, 30), 40.0, openings=(circle(0, 0, 27),), drilled=(out,)), "milling"))
    assert part is not None
    assert part.through == {0}
    assert part.drilled[0].depth == pytest.approx(3.0, abs=0.2)
    assert part.drilled[0].start == pytest.approx((-30.0, 0.0, 20.0), abs=0.2)
    blind = Drilled((-30.0, 0.0, 20.0), (1.0, 0.0, 0.0), 4.2, 15.0, "M5")
    part = flat_part(component(Prism(circle(0, 0, 30), 40.0, drilled=(blind,)), "milling"))
    assert part is not None
    assert (part.drilled, part.through) == ((blind,), frozenset())
