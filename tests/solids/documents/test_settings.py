"""Settings of the firmware: those of the paper's arm are the firmware's own; any others run it, too."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from layflat.errors import LayflatError, MachineError
from layflat.machine import Machine, changed, load, names
from layflat.rig import frames
from layflat.rig.driver import Capabilities, RigCommand
from layflat.rig.wire import Identity, Wire
from layflat.solids.documents import pins as board_pins
from layflat.solids.documents.pins import BoardPins
from layflat.solids.documents.settings import SHORTEST_CYCLE, firmware_settings
from tests.rig.firmwares import FOLDER, firmware
from tests.solids.documents.boards import FakeBoard, running, settings_module
from tests.solids.documents.machines import with_joints

MACHINES = [name for name in names() if load(name).controller is not None]


def test_the_firmwares_own_settings_are_those_of_the_papers_arm() -> None:
    assert (FOLDER / "settings.py").read_text() == firmware_settings(load("paper-arm"))


def exchange(board: FakeBoard, station: Any, message: bytes) -> bytes:
    """Return the payload of the reply to a message."""
    board.received = message
    board.sent.seek(0)
    board.sent.truncate()
    station.step()
    (reply,) = frames.Decoder().feed(board.sent.getvalue())
    return bytes(reply.payload)


@pytest.mark.parametrize("name", MACHINES)
def test_the_firmware_runs_with_the_settings_of_any_machine(name: str) -> None:
    check_board(load(name))


@pytest.mark.parametrize(("count", "outputs"), [(1, 8), (3, 0), (4, 3), (7, 8)])
def test_any_number_of_joints_and_outputs_has_pins_and_channels(count: int, outputs: int) -> None:
    check_board(with_joints(count, outputs))


def check_board(machine: Machine) -> None:
    """Check identity, readings and drives of a board with a machine's settings as its host sees them."""
    settings, wire = settings_module(firmware_settings(machine)), Wire.for_machine(machine)
    top = 2**settings.ADC_BITS - 1
    counts = [(1000 + 777 * i) % top for i in range(16)]
    with running(settings, counts) as (board, station):
        able = Capabilities.required_by(machine)._replace(shortest_cycle=1e-6 * SHORTEST_CYCLE)
        told = frames.unpack_words(exchange(board, station, frames.encode(frames.IDENTIFY_FRAME, 1, b"")))
        assert list(told) == Identity.for_machine(machine, able).words()
        Identity.from_words(told).check(machine, "board")
        n, outputs = len(machine.joints), 2 ** len(machine.interface.outputs) - 1
        volts = wire.voltage.low + np.linspace(0.3, 0.6, n) * (wire.voltage.value(wire.voltage.top) - wire.voltage.low)
        for number, reset in ((2, False), (3, True)):
            words = wire.command_words(RigCommand(volts, air=True, reset=reset, outputs=outputs))
            payload = exchange(board, station, frames.encode(frames.COMMAND_FRAME, number, frames.pack_words(words)))
        reading = wire.reading(frames.unpack_words(payload))
        shifts = {
            bits: settings.ADC_BITS - bits
            for bits in (settings.ANGLE_BITS, settings.PRESSURE_BITS, settings.SUPPLY_BITS)
        }
        assert reading.angles.tolist() == [wire.angle.value(counts[j] >> shifts[settings.ANGLE_BITS]) for j in range(n)]
        assert reading.pressures.tolist() == [
            wire.pressure.value(counts[n + j] >> shifts[settings.PRESSURE_BITS]) for j in range(n)
        ]
        assert reading.supply == wire.supply.value(counts[2 * n] >> shifts[settings.SUPPLY_BITS])
        dither = settings.DITHER_AMPLITUDE / 2
        low, span = settings.VOLTAGE_LOW / 1000, (settings.VOLTAGE_HIGH - settings.VOLTAGE_LOW) / 1000
        driven = np.array([board.duties[pin] for pin in settings.VALVE_PINS]) / 65536
        assert np.abs(driven - (volts - low) / span).max() <= dither + 2.0 / 2**settings.VOLTAGE_BITS
        assert all(board.pins[pin] == 1 for pin in (settings.AIR_PIN, *settings.OUTPUT_PINS))
        board.pins[settings.STOP_PIN] = 0
        station.step()
        assert not any(board.pins[pin] for pin in (settings.AIR_PIN, *settings.OUTPUT_PINS))


def test_no_pin_serves_two_signals_and_no_pwm_channel_two_valves() -> None:
    assert len(board_pins.VALVE_GPIOS) == firmware("station").MAX_JOINTS
    pins = [
        *board_pins.VALVE_GPIOS, *board_pins.OUTPUT_GPIOS, *board_pins.ADC_GPIOS, *board_pins.SELECT_GPIOS,
        board_pins.AIR_GPIO, board_pins.STOP_GPIO, board_pins.SERVICE_GPIO,
    ]  # fmt: skip
    assert len(set(pins)) == len(pins)
    assert set(pins) <= set(board_pins.BOARD_PINS)
    channels = {gpio % 16 for gpio in board_pins.VALVE_GPIOS}  # of PWM: those of a GPIO and of that 16 higher are one
    assert len(channels) == len(board_pins.VALVE_GPIOS)


@pytest.mark.parametrize("count", range(1, 8))
def test_channels_are_all_different_and_on_converters_that_are_there(count: int) -> None:
    pins = BoardPins.for_machine(with_joints(count))
    channels = [*pins.angles, *pins.pressures, pins.supply]
    assert len(set(channels)) == 2 * count + 1
    assert max(channels) < 8 * len(pins.selects)


@pytest.mark.parametrize(
    ("machine", "expected"),
    [
        ("rig-kevlar", "rig-kevlar: has no valve or sensors"),
        ("angle_sensor.bits=18", "angle_sensor.bits: is 18; the firmware's converters have up to 16"),
        ("controller.cycle=2 ms", "the rig needs 4000 us a cycle, the machine's is 2 ms"),
        ("valve.dither.frequency=40 kHz", "valve.dither.frequency: is 40000 Hz; the firmware adds up to 31250 Hz"),
    ],
)
def test_a_machine_that_the_firmware_cannot_serve_is_refused_with_the_limit(machine: str, expected: str) -> None:
    key, _, value = machine.partition("=")
    described = changed(load("paper-arm"), key, int(value) if value.isdigit() else value) if value else load(machine)
    with pytest.raises(LayflatError, match=re.escape(expected)) as error:
        firmware_settings(described)
    assert "\n" not in str(error.value)


def test_settings_without_converters_bits_are_those_of_a_converter_of_12() -> None:
    settings = settings_module(firmware_settings(load("paper-arm")))
    with running(settings, list(range(100, 108))) as (_, station):
        described = station.io.angle(1), station.io.supply()
    del settings.ADC_BITS
    with running(settings, list(range(100, 108))) as (_, station):
        assert (station.io.angle(1), station.io.supply()) == described == (101, 104)


def test_more_joints_than_pins_are_refused_with_their_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(board_pins, "VALVE_GPIOS", (2, 4, 10))  # arms have up to seven joints, as the firmware has pins
    with pytest.raises(
        MachineError, match=r"^picking-arm: arm.joints: has 4 joints; the firmware has pins for up to 3"
    ):
        firmware_settings(load("picking-arm"))


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [("ADC_BITS", 14, "ADC_BITS is 14; it is 12"), ("ANGLE_BITS", 16, "a sensor of 16 bits; its converter has 12")],
)
def test_the_board_refuses_a_converter_that_it_cannot_read(name: str, value: int, expected: str) -> None:
    settings = settings_module(firmware_settings(load("paper-arm")))
    setattr(settings, name, value)
    with pytest.raises(ValueError, match=expected), running(settings, []):
        pass
