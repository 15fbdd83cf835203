"""Walls, holes, bends and the strap's path as findings."""

from dataclasses import replace

import pytest

from layflat import extras
from layflat.solids.component import Component
from layflat.solids.loops import Loop, circle, rectangle
from layflat.solids.making import MAX_STRAP_MISS, making_findings, strap_finding
from layflat.solids.section import CrossSection
from layflat.solids.shapes import Hole, Prism, place
from tests.solids.checks.builds import built

pytestmark = pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")


def findings(
    *holes: Hole, making: str = "laser cutting", thickness: float = 2.0, openings: tuple[Loop, ...] = ()
) -> list[tuple[str, str]]:
    shape = Prism(rectangle(40.0, 20.0), thickness, holes, openings)
    part = Component("plate", "body", shape, "aluminium", making,  # type: ignore[arg-type]
                     (place(),), joint="small")  # fmt: skip
    found = making_findings((part,), built().sizes)
    return [(one.severity, one.what) for one in found if "plate" in one.where]


def test_a_part_with_thick_walls_has_no_findings() -> None:
    assert findings(Hole((0.0, 0.0), 4.0), Hole((10.0, 0.0), 4.0)) == []


def test_thin_walls_are_drilled_and_thinner_ones_refused() -> None:
    near = Hole((0.0, 6.5), 4.0)  # a wall of 1.5 mm
    assert [severity for severity, _ in findings(near)] == ["note"]
    assert findings(near, making="milling") == []
    too_near = Hole((0.0, 7.5), 4.0)  # a wall of 0.5 mm
    assert ("error", "a wall of 0.5 mm") in findings(too_near)
    assert ("error", "a wall of 0.5 mm") in findings(Hole((0.0, 0.0), 4.0), Hole((4.5, 0.0), 4.0), making="milling")


@pytest.mark.parametrize("name", ["paper-arm", "picking-arm", "single-joint-lift"])
def test_shipped_machines_can_be_made(name: str) -> None:
    assert not [one for one in making_findings(built(name).components, built(name).sizes) if one.severity == "error"]


def test_threaded_holes_count_as_drilled() -> None:
    assert findings(Hole((0.0, 0.0), 4.2, "M5"), thickness=8.0) == []
    assert [severity for severity, _ in findings(Hole((0.0, 0.0), 4.2), thickness=8.0)] == ["note"]
    assert findings(Hole((0.0, 0.0), 0.5), making="milling")[0] == ("error", "a hole of 0.5 mm")


def test_walls_around_openings_and_thin_plates_are_refused() -> None:
    assert findings(making="milling", openings=(rectangle(37.0, 17.0),)) == []
    assert findings(making="milling", openings=(rectangle(39.4, 10.0),)) == [("error", "a wall of 0.3 mm")]
    assert findings(making="milling", thickness=0.4) == [("error", "a wall of 0.4 mm")]


def test_a_wall_between_arcs_is_as_thick_as_the_difference_of_their_radii() -> None:
    for outer in (25.0, 30.0, 43.7):
        shape = Prism(circle(0.0, 0.0, outer), 50.0, openings=(circle(0.0, 0.0, outer - 1.0).turned(0.3),))
        part = Component("tube", "body", shape, "aluminium-tube", "milling", (place(),), joint="small")
        found = making_findings((part,), built().sizes)
        assert not [one for one in found if "tube" in one.where]


def test_the_straps_path_is_within_a_tenth_of_a_millimetre() -> None:
    sizes = built().sizes["small"]
    assert CrossSection(sizes).strap_miss <= MAX_STRAP_MISS
    assert strap_finding(sizes, "small") is None


def test_a_strap_over_a_large_nose_is_a_finding() -> None:
    sizes = built().sizes["small"]
    strap = sizes.joint.strap.model_copy(update={"thickness": 20 * sizes.joint.strap.thickness})
    machine = sizes.design.machine
    joint = sizes.joint.model_copy(update={"strap": strap})
    design = replace(sizes.design, machine=machine.model_copy(update={"joint": {**machine.joint, "small": joint}}))
    finding = strap_finding(replace(sizes, design=design), "small")
    assert finding is not None
    assert "strap.thickness" in finding.right
