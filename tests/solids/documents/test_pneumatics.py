"""The pneumatic diagram shows every component and tube, readably, for any machine."""

from __future__ import annotations

import re

import pytest

from layflat.errors import MachineError
from layflat.machine import Machine, load, names
from layflat.solids.documents import components
from layflat.solids.documents.components import list_components
from layflat.solids.documents.pneumatics import draw_pneumatics
from layflat.solids.documents.tubes import list_tubes
from tests.solids.documents.machines import UNUSUAL_MACHINES, with_joints
from tests.solids.documents.pictures import check_readable, labels

MACHINES = [name for name in names() if load(name).valve is not None]


def check_diagram(machine: Machine) -> None:
    svg = draw_pneumatics(machine)
    check_readable(svg)
    texts = [label.text for label in labels(svg)]
    pair = machine.valve is not None and machine.valve.kind == "switching"
    for part in list_components(machine):
        drawn = f"{part.tag}a" if pair and part.tag.endswith("V1") and part.tag != "0V1" else part.tag
        assert texts.count(drawn) >= 1, part.tag
        assert any(text.startswith(part.name[:40]) for text in texts)
    for row in list_tubes(machine):
        if re.fullmatch(r"\dA[123]", row.end) or (row.origin == "0Z2" and row.bore is not None):
            assert f"{row.number} d{1e3 * (row.bore or 0.0):.3g}" in texts, row


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_is_drawn_whole_and_readably(name: str) -> None:
    check_diagram(load(name))


@pytest.mark.parametrize("name", UNUSUAL_MACHINES)
def test_an_unusual_machine_is_drawn_whole_and_readably(name: str) -> None:
    check_diagram(UNUSUAL_MACHINES[name])


@pytest.mark.parametrize("count", range(1, 8))
def test_any_number_of_joints_fits_a_sheet(count: int) -> None:
    check_diagram(with_joints(count))


def test_a_single_hose_has_no_second_one_and_a_plug() -> None:
    svg = draw_pneumatics(load("single-joint-lift"))
    assert "1A2" not in svg
    assert "1A1" in svg


def test_a_valve_without_a_symbol_is_refused_by_its_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(components, "VALVE_NAMES", {"spool": "5/3 proportional valve"})
    with pytest.raises(MachineError, match=r"^paper-arm-switching: valve.kind: is 'switching'; documents know"):
        draw_pneumatics(load("paper-arm-switching"))


def test_a_rig_without_valves_is_refused() -> None:
    with pytest.raises(MachineError, match="has no valve or sensors"):
        draw_pneumatics(load("rig-kevlar"))
