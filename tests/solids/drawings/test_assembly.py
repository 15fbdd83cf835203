"""Sheets of assemblies: every item has a balloon or is said to be hidden, sizes are those of the parts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from layflat.solids.component import Component
from layflat.solids.drawings.assembly import DrawnMachine, assemblies, assembly_sheet, list_sheet
from layflat.solids.drawings.projection import FRONT_VIEW, LEFT_VIEW, cut, project
from layflat.solids.drawings.table import number_text
from layflat.solids.hardware import rod, sleeve
from layflat.solids.loops import rectangle
from layflat.solids.shapes import ALONG_X, Prism, place
from tests.solids.drawings.parts import component, joint_parts
from tests.solids.drawings.sheets import overlapping_texts, texts, texts_off_the_sheet

NUMBERS = {joint: list(range(1, len(joint_parts(joint)) + 1)) for joint in ("small", "large")}


def drawn(parts: Sequence[Component], numbers: Sequence[int]) -> DrawnMachine:
    return DrawnMachine("arm", parts, numbers, [0.05] * len(parts))


@pytest.mark.parametrize("joint", ["small", "large"])
def test_every_item_of_a_joint_stands_on_its_sheet_and_in_the_list(joint: str) -> None:
    parts = joint_parts(joint)
    (whole,) = assemblies(drawn(parts, NUMBERS[joint]))
    paper = assembly_sheet(whole)
    written = texts(paper)
    hidden = (
        " ".join(text.removeprefix("Not visible: ") for text in written if "," in text)
        .replace(",", " ")
        .replace(".", " ")
    )
    assert set(map(str, NUMBERS[joint])) <= set(written) | set(hidden.split())
    assert sum(text.isdigit() for text in written) > 0.7 * len(parts)
    assert not overlapping_texts(paper)
    assert not texts_off_the_sheet(paper)
    listed = list_sheet(whole, dict(zip(NUMBERS[joint], parts, strict=True)))
    assert all(any(text.startswith(one.name) for text in texts(listed)) for one in parts)
    assert not overlapping_texts(listed)


def test_balloons_with_long_numbers_stand_beside_each_other() -> None:
    bars = [replace(component(rod(2, 4)), places=(place(2.5 * k),)) for k in range(40)]
    (sheet,) = assemblies(drawn(bars, range(1001, 1041)))
    paper = assembly_sheet(sheet)
    assert {str(number) for number in range(1001, 1041)} <= set(texts(paper))
    assert not overlapping_texts(paper)


def test_overall_sizes_are_those_of_what_is_drawn() -> None:
    parts = joint_parts()
    (whole,) = assemblies(drawn(parts, NUMBERS["small"]))
    front = project("front", parts, whole.items, FRONT_VIEW, whole.frame)
    width, height = front.box[1] - front.box[0]
    written = texts(assembly_sheet(whole))
    assert number_text(float(width), 1) in written
    assert number_text(float(height), 1) in written


def test_nearer_parts_hide_further_ones() -> None:
    plate = replace(component(Prism(rectangle(20, 20), 2.0)), places=(place(z=10.0),))
    post, other = component(rod(5, 8)), replace(component(rod(5, 8)), places=(place(30.0),))
    seen = project("front", [plate, post, other], ["1", "2", "3"], FRONT_VIEW, place()).visible()
    assert set(seen) == {"1", "3"}
    assert seen["3"][1] == pytest.approx([30.0, 0.0], abs=0.5)
    assert set(project("left", [plate, post], ["1", "2"], LEFT_VIEW, place()).visible()) == {"1", "2"}


def test_what_lies_in_the_hole_of_a_nearer_part_is_seen() -> None:
    ring = replace(component(sleeve(40, 20, 5)), places=(place(z=10.0),))
    seen = project("front", [ring, component(rod(6, 5))], ["1", "2"], FRONT_VIEW, place()).visible()
    assert set(seen) == {"1", "2"}
    assert np.hypot(*seen["1"][1]) == pytest.approx(15.0, abs=1.0)


def test_a_section_shows_parts_that_its_plane_cuts() -> None:
    below = component(rod(5, 8))
    through = replace(component(rod(5, 8)), places=(place(20.0, 0.0, -4.0),))
    across = replace(component(rod(5, 8)), places=(place(40.0, 0.0, 0.0, ALONG_X),))
    view = cut("section", [below, through, across], ["1", "2", "3"], place())
    assert [shadow.item for shadow in view.shadows] == ["2", "3"]
    assert np.ptp(view.shadows[1].lines[0], axis=0) == pytest.approx([8.0, 5.0])


def test_an_arm_has_a_sheet_of_each_joint_and_of_the_whole() -> None:
    parts = []
    for joint in ("shoulder", "elbow"):
        parts += [replace(one, joint=joint) for one in joint_parts()]
        parts.append(replace(component(rod(20, 300), "sawing"), joint=joint, tags=frozenset({"link"})))
        parts.append(replace(component(rod(5, 30), "turning"), joint=joint))
    numbers = list(range(1, len(parts) + 1))
    whole, *joints = assemblies(drawn(parts, numbers))
    assert [one.file for one in (whole, *joints)] == ["00-assembly", "00-joint-shoulder", "00-joint-elbow"]
    count = len(joint_parts())
    assert set(whole.items) == {"shoulder", "elbow", *map(str, (count + 1, count + 2, 2 * count + 3, 2 * count + 4))}
    assert all(len(one.components) == count for one in joints)
    assert "shoulder" in " ".join(texts(assembly_sheet(whole)))
