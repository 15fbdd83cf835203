"""The wiring diagram shows every wire and device, readably, for any machine."""

from __future__ import annotations

import pytest

from layflat.machine import Machine, load, names
from layflat.solids.documents.wires import list_wires
from layflat.solids.documents.wiring import draw_wiring, place_devices
from tests.solids.documents.machines import UNUSUAL_MACHINES, with_joints
from tests.solids.documents.pictures import check_readable, labels

MACHINES = [name for name in names() if load(name).controller is not None]


def check_diagram(machine: Machine) -> None:
    svg, wires, devices = draw_wiring(machine), list_wires(machine), place_devices(machine)
    check_readable(svg)
    texts = [label.text for label in labels(svg)]
    for wire in wires:
        own = f"{wire.number} {wire.colour}".strip()
        assert sum(text == own or text.startswith(f"{own} ") for text in texts) == 1, wire
    drawn = {name for device in devices for name, _, _ in device.ends()}
    ends = {end for wire in wires for end in (wire.origin, wire.end)}
    assert {end for end in ends if not end.startswith(("X", "PE", "host"))} == drawn
    for device in devices:
        x, y = device.corner
        others = (other for other in devices if other is not device)
        assert not any(
            other.corner[0] < x + device.width
            and x < other.corner[0] + other.width
            and other.corner[1] < device.bottom
            and y < other.bottom
            for other in others
        ), device


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_is_drawn_whole_and_readably(name: str) -> None:
    check_diagram(load(name))


@pytest.mark.parametrize("name", UNUSUAL_MACHINES)
def test_an_unusual_machine_is_drawn_whole_and_readably(name: str) -> None:
    check_diagram(UNUSUAL_MACHINES[name])


@pytest.mark.parametrize(("count", "outputs"), [(1, 8), (2, 0), (3, 1), (4, 0), (5, 2), (6, 8), (7, 8)])
def test_any_number_of_joints_and_outputs_fits_a_sheet(count: int, outputs: int) -> None:
    check_diagram(with_joints(count, outputs))
