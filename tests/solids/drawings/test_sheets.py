"""Sheets of parts: title block, hole table, sizes and fits stand on them, and no text covers another one."""

from itertools import pairwise
from math import radians

import numpy as np
import pytest

from layflat.design import SizingRequest, size_joint
from layflat.solids.component import Component
from layflat.solids.drawings.flat import flat_part
from layflat.solids.drawings.paper import FORMATS, Path, Text, svg_and_pdf
from layflat.solids.drawings.sheets import PartSheet, part_sheet
from layflat.solids.drawings.table import Fits, fits_of, hole_table, number_text
from layflat.solids.hardware import rod, sleeve
from layflat.solids.joint import joint_components, joint_sizes
from layflat.solids.loops import rectangle
from layflat.solids.shapes import ALONG_X, Drilled, Hole, Joined, Prism, Turned, joined, place
from layflat.solids.standard.materials import material
from tests.solids.drawings.parts import component, joint_parts, made_parts
from tests.solids.drawings.sheets import overlapping_texts, text_box, texts, texts_off_the_sheet

PARTS = [(joint, one) for joint in ("small", "large") for one in made_parts(joint)]
IDS = [f"{joint}-{one.name}" for joint, one in PARTS]


def sheet_of(one: Component, fits: Fits | None = None) -> PartSheet:
    return PartSheet(one, "7", 0.1234, "paper-arm", "07-part", fits or Fits())


@pytest.mark.parametrize(("joint", "one"), PARTS, ids=IDS)
def test_the_sheet_of_a_part_can_be_worked_from(joint: str, one: Component) -> None:
    paper = part_sheet(sheet_of(one, fits_of(joint_parts(joint))))
    written = texts(paper)
    assert not overlapping_texts(paper)
    assert not texts_off_the_sheet(paper)
    assert {one.name, "7", "paper-arm", one.making, str(one.quantity), "123 g", paper.format} <= set(written)
    assert any(material(one.material).grade in text for text in written)
    part = flat_part(one)
    assert not isinstance(one.shape, Joined)
    holes = one.shape.drilled if part is None else (*part.holes, *part.drilled)
    for number in range(1, len(holes) + 1):
        assert written.count(str(number)) >= 2, "a number beside the hole, and one in the table"
    if part is None or (width := part.box[1] - part.box[0]) is None:
        return
    if not any(text.startswith("Ø") for text in written):
        assert {number_text(float(size), 1) for size in width} <= set(written)
    if part.bends:
        assert sum("inside" in text for text in written) >= len(part.bends)


def test_the_hole_table_has_every_hole_with_position_thread_and_depth() -> None:
    holes = (Hole((1.5, -2.25), 4.2, "M5"), Hole((10, 0), 12.0), Hole((-3, 4), 5.5))
    drilled = (Drilled((20.0, 0.0, 3.0), (-1.0, 0.0, 0.0), 2.5, 8.0, "M3"),)
    part = flat_part(component(Prism(rectangle(40, 30), 6.0, holes, drilled=drilled)))
    assert part is not None
    table = hole_table(part, Fits((), (12.0,)))
    assert table.head == ("No.", "x", "y", "z", "Ø", "thread, fit", "depth", "along")
    assert table.rows == (
        ("1", "1.5", "-2.25", "", "4.2", "M5", "through", ""),
        ("2", "10", "0", "", "12", "H7", "through", ""),
        ("3", "-3", "4", "", "5.5", "", "through", ""),
        ("4", "20", "0", "3", "2.5", "M3", "8.0", "-x"),
    )


def test_fits_come_from_shaft_and_bushes_of_the_assembly() -> None:
    fits = fits_of(joint_parts())
    (shaft,) = fits.shafts
    named = {one.name: part_sheet(sheet_of(one, fits)) for one in made_parts()}
    assert f"Ø{shaft:g} h6" in texts(named["shaft"])
    assert f"Ø{shaft:g} H7" in texts(named["brake disc"])
    for name in ("arm plate", "lower end plate", "cam of hose A"):
        assert "H7" in texts(named[name]), name


def test_a_turned_part_has_all_its_diameters_and_lengths() -> None:
    disc = next(one for one in made_parts() if one.name == "brake disc")
    written = texts(part_sheet(sheet_of(disc)))
    radii = {float(x) for x, _ in disc.shape.outline.points()}  # type: ignore[union-attr]
    assert {f"Ø{number_text(2 * r, 1)}" for r in radii} <= set(written)
    heights = sorted({float(z) for _, z in disc.shape.outline.points()})  # type: ignore[union-attr]
    lengths = [b - a for a, b in pairwise(heights)]
    assert {number_text(size, 1) for size in (*lengths, sum(lengths))} <= set(written)


@pytest.mark.parametrize(
    ("shape", "scale"),
    [(rod(7, 12), "10:1"), (sleeve(30, 10, 60), "2:1"), (rod(20, 200), "1:1"), (rod(20, 700), "1:2")],
)
def test_scales_are_standard_ones_and_as_large_as_fits(shape: Turned, scale: str) -> None:
    paper = part_sheet(sheet_of(component(shape, "turning")))
    assert scale in texts(paper)
    width, height = FORMATS[paper.format]
    points = [line for one in paper.elements if isinstance(one, Path) for line in one.lines]
    assert all(0 <= line.min() and line[:, 0].max() <= width and line[:, 1].max() <= height for line in points)


def test_a_part_of_several_pieces_has_three_views_with_all_holes() -> None:
    eye = Prism(rectangle(40, 20), 4.0, (Hole((10.0, 0.0), 5.5),))
    across = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # its own z along -y of the other one
    shape = joined((eye, place(5.0, 6.0, 7.0)), (sleeve(20, 16, 100), place(24.0, 6.0, 9.0, ALONG_X)),
                   (eye, place(130.0, 6.0, 9.0, across)))  # fmt: skip
    paper = part_sheet(sheet_of(component(shape, "milling", size="180 mm long, ends flattened")))
    written = texts(paper)
    assert not overlapping_texts(paper)
    assert written.count("1") >= 2
    assert written.count("2") >= 2
    assert {"145", "-z", "+y", "180 mm long, ends flattened."} <= set(written) | {"145"}
    assert number_text(145.0 + 20.0, 1) in written
    assert any("Ø20" in text and "Ø16" in text for text in written)


def test_texts_are_legible_on_a4() -> None:
    for _, one in PARTS:
        paper = part_sheet(sheet_of(one))
        shrink = FORMATS["A4"][0] / FORMATS[paper.format][0]
        for text in (element for element in paper.elements if isinstance(element, Text)):
            assert text.height * shrink > 1.2, text
            assert text_box(text)[0] >= 0


def test_the_same_part_gives_the_same_bytes() -> None:
    one = made_parts()[1]
    assert svg_and_pdf(part_sheet(sheet_of(one))) == svg_and_pdf(part_sheet(sheet_of(one)))
    svg, pdf = svg_and_pdf(part_sheet(sheet_of(one)))
    assert b"lower end plate" in svg
    assert pdf.startswith(b"%PDF")
    assert b"Date" not in pdf


@pytest.mark.parametrize(("torque", "stroke", "supply"), [(20.0, 110.0, 6e5), (95.0, 125.0, 6.5e5)])
def test_no_text_covers_another_one_on_sheets_of_sized_joints(torque: float, stroke: float, supply: float) -> None:
    machine = size_joint(SizingRequest(torque, radians(stroke), supply)).design.machine
    parts = joint_components(joint_sizes(machine, next(iter(machine.joints))))
    for one in (part for part in parts if not part.bought):
        paper = part_sheet(sheet_of(one, fits_of(parts)))
        assert not overlapping_texts(paper), one.name
        assert not texts_off_the_sheet(paper), one.name
