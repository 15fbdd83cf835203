"""The list of tubes agrees with the description, with the rule for bores, and with itself."""

from __future__ import annotations

import csv
import io
import re
from math import pi, sqrt
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import MachineError
from layflat.machine import Machine, build, changed, load
from layflat.machine.tube import volume
from layflat.solids.documents.components import list_components
from layflat.solids.documents.tubes import COLUMNS, TubeRow, list_tubes, tubes_csv
from layflat.solids.tubing import SOLD_TUBES, choose_tube
from tests.solids.documents.machines import with_joints

MACHINES = ["paper-arm", "picking-arm", "single-joint-lift", "paper-arm-adjustable", "paper-arm-switching"]


def hose_tubes(machine: Machine) -> list[TubeRow]:
    """Return the tubes that end at a hose."""
    return [row for row in list_tubes(machine) if re.fullmatch(r"\dA[12]", row.end)]


@pytest.mark.parametrize("table", ["line", "joint.large.line"])
def test_a_described_line_is_the_tube_of_its_hoses(table: str) -> None:
    line = {"length": "0.8 m", "bore": "5.7 mm"}
    arm = load("paper-arm").model_dump(mode="json")
    joints = arm["joint"].values() if table.startswith("joint") else [arm]
    for joint in joints:
        joint["line"] = dict(line)
    machine = changed(load("paper-arm"), "line", line) if table == "line" else rebuilt(arm)
    for row in hose_tubes(machine):
        assert (row.length, row.bore, row.outer, row.note) == (0.8, 5.7e-3, 8e-3, "as [line]")
        described = machine.lines["large"]
        assert described is not None
        assert row.volume == volume(described)


def rebuilt(arm: dict[str, Any]) -> Machine:
    """Return the machine of plain tables."""
    return build(arm, {}, "arm.toml")


@pytest.mark.parametrize(
    ("bore", "outer", "note"),
    [("6 mm", 8e-3, "a bore of 5.7 mm"), ("3.3 mm", None, "hose nozzles"), ("20 mm", None, "hose nozzles")],
)
def test_a_bore_that_is_not_sold_is_kept_and_noted(bore: str, outer: float | None, note: str) -> None:
    for row in hose_tubes(changed(load("paper-arm"), "line", {"length": "0.5 m", "bore": bore})):
        assert row.outer == outer
        assert row.bore == pytest.approx(float(bore.split(maxsplit=1)[0]) / 1e3)
        assert note in row.note


@pytest.mark.parametrize("name", MACHINES)
def test_without_a_line_a_tube_takes_half_of_the_dead_volume_at_most(name: str) -> None:
    machine = load(name)
    volumes = [joint.hose.dead_volume for joint in machine.joints.values()]
    for row in hose_tubes(machine):
        assert row.volume == pytest.approx(0.5 * volumes[int(row.end[0]) - 1])
        assert "without [line] the dead volume" in row.note


@given(st.floats(1e-10, 1e-7), st.floats(0.05, 5.0))
def test_the_bore_is_the_narrowest_that_does_not_throttle(needed: float, length: float) -> None:
    bore, outer, enough = choose_tube(needed, length)
    by_formula = {d: 0.029 * d**2 / sqrt(length / d**1.25 + 510.0) for _, d in SOLD_TUBES}  # beater2007
    wide = [d for d, conductance in by_formula.items() if conductance >= 2.0 * needed]
    assert (bore, enough) == (min(wide), True) if wide else (max(by_formula), False)
    assert (outer, bore) in SOLD_TUBES


@pytest.mark.parametrize("name", MACHINES)
def test_every_valve_hose_and_sensor_is_at_the_end_of_a_tube(name: str) -> None:
    machine = load(name)
    rows = list_tubes(machine)
    assert [row.number for row in rows] == [f"T{i}" for i in range(1, len(rows) + 1)]
    assert len({(row.origin, row.end) for row in rows}) == len(rows)
    tags = {re.sub("[ab]$", "", end.partition(":")[0]) for row in rows for end in (row.origin, row.end)}
    screwed_together = {"0V2", "0V3", "0S1"}  # into the service unit and the distributor
    electric = {part.tag for part in list_components(machine) if part.tag.endswith("S2")}
    assert {part.tag for part in list_components(machine)} - electric <= tags | screwed_together
    assert sum("silencer" in row.note for row in rows) == 2 * len(machine.joints) + 2


def test_a_single_hose_has_a_plugged_port_and_one_tube() -> None:
    rows = list_tubes(load("single-joint-lift"))
    assert [row.origin for row in rows if row.end == "plug"] == ["1V1:2"]
    assert len([row for row in rows if row.end.startswith("1A")]) == 1


@pytest.mark.parametrize("count", [1, 6])
def test_the_file_has_the_values_in_its_units(count: int) -> None:
    machine = with_joints(count)
    table = list(csv.reader(io.StringIO(tubes_csv(machine))))
    assert tuple(table[0]) == COLUMNS
    for cells in table[1:]:
        if cells[3]:
            bore, length, air = (float(cells[i]) for i in (3, 5, 6))
            assert air == pytest.approx(pi / 4 * bore**2 * length, rel=1e-3)  # mm2 m = ml


def test_a_rig_without_valves_is_refused() -> None:
    with pytest.raises(MachineError, match="has no valve or sensors"):
        list_tubes(load("rig-kevlar"))
