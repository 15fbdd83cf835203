"""Every part of an assembly stands in the list once, and equal parts stand in one row."""

from __future__ import annotations

import pytest

from layflat.solids.parts_list import common_name, list_parts
from tests.solids.joints import components_of, mass_by_name

ARM = (*components_of("paper-arm", "large"), *components_of("paper-arm", "small"))
PARTS = list_parts(ARM, mass_by_name)


def test_the_list_has_every_part_of_the_assembly_and_its_mass() -> None:
    assert sum(part.quantity for part in PARTS.parts) == sum(one.quantity for one in ARM)
    assert PARTS.mass == pytest.approx(sum(mass_by_name(one) * one.quantity for one in ARM), abs=1e-9)
    assert sum(PARTS.masses.values()) == pytest.approx(PARTS.mass, abs=1e-9)
    assert set(PARTS.masses) == {"large", "small"}
    for one in ARM:
        assert any(one is other for other in PARTS.part(one).components)


def test_made_parts_are_numbered_from_1_and_bought_ones_from_101() -> None:
    made = [part.number for part in PARTS.parts if not part.bought]
    bought = [part.number for part in PARTS.parts if part.bought]
    assert made == list(range(1, len(made) + 1))
    assert bought == list(range(101, 101 + len(bought)))


def test_two_equal_joints_have_the_rows_of_one_and_twice_the_parts() -> None:
    one = list_parts(components_of("paper-arm", "small"), mass_by_name)
    pair = [*components_of("paper-arm", "small", name="a"), *components_of("paper-arm", "small", 0.4, name="b")]
    both = list_parts(pair, mass_by_name)
    assert len(both.parts) == len(one.parts)
    for single, double in zip(one.parts, both.parts, strict=True):
        assert (double.name, double.quantity) == (single.name, 2 * single.quantity)
        assert double.joints == {"a": single.quantity, "b": single.quantity}


def test_a_pose_changes_neither_rows_nor_numbers() -> None:
    rows = [
        [
            (part.number, part.name, part.quantity, part.material, part.stock, part.size)
            for part in list_parts(found, mass_by_name).parts
        ]
        for found in (components_of("paper-arm", "small"), components_of("paper-arm", "small", -0.7))
    ]
    assert rows[0] == rows[1]


def test_bought_parts_of_one_designation_stand_in_one_row() -> None:
    bought = [(part.material, part.size) for part in PARTS.parts if part.bought]
    assert len(bought) == len(set(bought))
    nuts = next(part for part in PARTS.parts if part.material.startswith("ISO 4032 M6"))
    assert nuts.name == "nut"
    assert len(nuts.names) > 1


@pytest.mark.parametrize(
    ("names", "name"),
    [
        (["shaft"], "shaft"),
        (["hose A", "hose B"], "hose A, B"),
        (["nut of the clamp", "nut of the brake"], "nut"),
        (["lower screw of a standoff", "upper screw of a standoff"], "screw"),
        (["shell A", "cover B"], "shell A, cover B"),
    ],
)
def test_names_of_several_uses_have_one_in_common(names: list[str], name: str) -> None:
    assert common_name(names) == name
