"""The list of wires has every pin and channel of the firmware's settings, and no terminal that is not fed."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter

import pytest

from layflat.errors import MachineError
from layflat.machine import Machine, changed, load, names
from layflat.solids.documents.pins import BOARD_PINS
from layflat.solids.documents.settings import firmware_settings
from layflat.solids.documents.wires import COLUMNS, WireRow, list_wires, wires_csv
from tests.rig.firmwares import FOLDER
from tests.solids.documents.boards import settings_module
from tests.solids.documents.machines import with_joints

MACHINES = [name for name in names() if load(name).controller is not None]
IEC_60757 = {"BK", "BN", "RD", "OG", "YE", "GN", "BU", "VT", "GY", "WH", "PK", "TQ"}


def wire_to(wires: list[WireRow], end: str) -> WireRow:
    (found,) = (wire for wire in wires if end in {wire.origin, wire.end})
    return found


def check_wires(machine: Machine) -> None:
    wires, settings = list_wires(machine), settings_module(firmware_settings(machine))
    assert [wire.number for wire in wires] == list(range(1, len(wires) + 1))
    used = {int(end[5:]) for wire in wires for end in (wire.origin, wire.end) if end.startswith("A1:GP")}
    assert used == {
        *settings.VALVE_PINS, *settings.OUTPUT_PINS, *settings.ADC_PINS, *settings.ADC_SELECTS,
        settings.AIR_PIN, settings.STOP_PIN, settings.SERVICE_PIN,
    }  # fmt: skip
    for wire in wires:
        if wire.origin.startswith("A1:GP"):
            assert wire.note.startswith(f"pin {BOARD_PINS[int(wire.origin[5:])]}")
    for j, (angle, pressure) in enumerate(zip(settings.ANGLE_CHANNELS, settings.PRESSURE_CHANNELS, strict=True), 1):
        for channel, sensor in ((angle, f"{j}S2:2"), (pressure, f"{j}S1:U")):
            assert wire_to(wires, sensor).end == f"A{2 + channel // 8}:CH{channel % 8}"
    assert wire_to(wires, "0S1:U").end == f"A{2 + settings.SUPPLY_CHANNEL // 8}:CH{settings.SUPPLY_CHANNEL % 8}"
    for j, pin in enumerate(settings.VALVE_PINS, start=1):
        assert wire_to(wires, f"{j}K1:IN").origin == f"A1:GP{pin}"
    for i, pin in enumerate(settings.OUTPUT_PINS, start=1):
        driver = wire_to(wires, f"0K{i + 1}:IN")
        assert (driver.origin, driver.signal) == (f"A1:GP{pin}", machine.interface.outputs[i - 1])
    for wire in wires:
        assert wire.colour == "" or set(re.findall("..", wire.colour)) <= IEC_60757, wire
    at_devices = Counter(
        end for wire in wires for end in (wire.origin, wire.end) if not end.startswith(("X", "A1", "PE"))
    )
    assert set(at_devices.values()) == {1}


@pytest.mark.parametrize("name", MACHINES)
def test_wires_are_those_of_the_firmwares_settings(name: str) -> None:
    check_wires(load(name))


@pytest.mark.parametrize(("count", "outputs"), [(1, 0), (3, 2), (4, 8), (7, 8)])
def test_wires_of_any_number_of_joints(count: int, outputs: int) -> None:
    check_wires(with_joints(count, outputs))


def test_pins_are_those_of_the_firmwares_own_table() -> None:
    table = (FOLDER / "README.md").read_text()
    wires = list_wires(load("paper-arm"))
    assert "| 2, 4 | valves of joints 1, 2 |" in table
    assert [wire_to(wires, f"{j}K1:IN").origin for j in (1, 2)] == ["A1:GP2", "A1:GP4"]
    assert "an amplifier by 3.03: 0 to 10 V" in table
    assert "gain 3.03;" in wire_to(wires, "1K1:IN").note
    assert "| 16, 17, 18, 19 | converter: DOUT, CS, CLK, DIN |" in table
    by_gpio = {16: "DOUT", 17: "CS", 18: "CLK", 19: "DIN"}
    assert {gpio: wire_to(wires, f"A1:GP{gpio}").end for gpio in by_gpio} == {
        gpio: f"A2:{name}" for gpio, name in by_gpio.items()
    }


def test_an_amplifier_has_the_gain_and_offset_of_the_valves_voltages() -> None:
    arm = changed(changed(load("paper-arm"), "valve.centre_voltage", "0 V"), "valve.volts_to_full", "10 V")
    assert "gain 6.06, -10 V;" in wire_to(list_wires(arm), "1K1:IN").note


def test_regulators_and_callipers_stay_at_a_fixed_voltage() -> None:
    wires = list_wires(load("paper-arm-adjustable"))
    for tag in ("1V2", "1V3", "2V2", "2V3"):
        wire = wire_to(wires, f"{tag}:U")
        assert wire.origin == "X3:10V"
        assert "the firmware has no output" in wire.note


def test_the_file_has_a_row_a_wire() -> None:
    table = list(csv.reader(io.StringIO(wires_csv(load("picking-arm")))))
    assert tuple(table[0]) == COLUMNS
    assert len(table) == 1 + len(list_wires(load("picking-arm")))
    assert all(len(row) == len(COLUMNS) for row in table)


def test_a_rig_without_valves_is_refused() -> None:
    with pytest.raises(MachineError, match="has no valve or sensors"):
        list_wires(load("rig-kevlar"))
