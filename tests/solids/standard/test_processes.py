"""Processes and what they can make."""

import pytest

from layflat.errors import DesignError
from layflat.solids.standard.processes import (
    PROCESSES,
    check_bend,
    check_hole,
    check_wall,
    process,
    smallest_bend,
    smallest_hole,
    smallest_wall,
)


@pytest.mark.parametrize("name", PROCESSES)
def test_what_is_on_the_limit_can_be_made_and_a_hair_less_cannot(name: str) -> None:
    for thickness in (0.0, 0.002, 0.008):
        wall, hole = smallest_wall(name, thickness), smallest_hole(name, thickness)
        assert check_wall(name, wall, "cam", thickness) is None
        assert check_wall(name, 0.99 * wall, "cam", thickness) is not None
        assert check_hole(name, hole, "cam", thickness) is None
        assert check_hole(name, 0.99 * hole, "cam", thickness) is not None


def test_limits_grow_with_the_sheet() -> None:
    assert smallest_wall("laser cutting", 0.008) == 0.008
    assert smallest_hole("laser cutting", 0.0005) == 0.001
    assert smallest_wall("milling", 0.008) == 0.001
    assert smallest_bend("stainless-steel", 0.002) < smallest_bend("aluminium", 0.002)


def test_a_finding_says_where_what_and_what_is_right() -> None:
    finding = check_wall("printing", 0.0008, "potentiometer mount: rib")
    assert str(finding) == "potentiometer mount: rib: a wall of 0.8 mm; printing needs 1.2 mm at least"
    assert finding is not None
    assert finding.severity == "error"
    bend = check_bend("aluminium", 0.002, "bracket", 0.002)
    assert str(bend) == "bracket: a bend of 2 mm; bending of aluminium needs 9 mm at least"


def test_unknown_processes_and_what_is_not_bent_are_refused() -> None:
    with pytest.raises(DesignError, match="unknown process 'forging'; known are laser cutting, milling"):
        process("forging")
    with pytest.raises(DesignError, match="POM is not bent; bend aluminium"):
        smallest_bend("POM", 0.002)
