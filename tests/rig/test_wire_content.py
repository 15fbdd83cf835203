from __future__ import annotations

from contextlib import suppress
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat import changed, load
from layflat.machine.parameters import control, joints
from layflat.physics.sensor import Sensor, read_sensor
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import RigCommand, SensorReading
from layflat.rig.wire import SEQUENCE_MODULUS, Converter, Wire, WireError, is_later, next_sequence

ARM = load("paper-arm")
FINE = changed(changed(ARM, "angle_sensor.bits", 24), "interface.supply_bits", 16)
WIRES = {"12 bits": (ARM, Wire.for_machine(ARM)), "24 bits": (FINE, Wire.for_machine(FINE))}
JOINTS = {name: joints(machine)[0] for name, (machine, _) in WIRES.items()}

half_ranges = st.floats(1e-3, 1e7)
bits = st.integers(4, 24)
numbers = st.integers(0, SEQUENCE_MODULUS - 1)
pairs = st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=2)


def same(one: SensorReading, other: SensorReading) -> bool:
    arrays = np.array_equal(one.angles, other.angles) and np.array_equal(one.pressures, other.pressures)
    return arrays and one[2:] == other[2:]


@pytest.mark.parametrize("name", WIRES)
@given(
    angles=pairs,
    pressures=pairs,
    supply=st.integers(0, 4096),
    stopped=st.booleans(),
    device=st.sampled_from(DeviceState),
)
def test_the_host_sees_what_the_sensors_said_bit_for_bit(
    name: str, angles: list[float], pressures: list[float], supply: int, stopped: bool, device: DeviceState
) -> None:
    (_, wire), law = WIRES[name], JOINTS[name]
    reading = SensorReading(
        np.array([read_sensor(law.angle_sensor, angle, 0.0) for angle in angles]),
        np.array([read_sensor(law.pressure_sensor, 4e5 * pressure, 0.0) for pressure in pressures]),
        wire.supply.value(supply),
        stopped,
        device,
    )
    words = wire.reading_words(reading)
    assert len(words) == wire.reading_size
    assert all(0 <= word < 1 << 16 for word in words)
    back = wire.reading(words)
    assert same(back, reading)
    assert isinstance(back.device, DeviceState)


@given(st.lists(st.floats(allow_nan=True), min_size=2, max_size=2), st.booleans(), st.booleans())
def test_a_command_arrives_within_half_a_count_and_never_outside_the_range(
    voltages: list[float], air: bool, reset: bool
) -> None:
    _, wire = WIRES["12 bits"]
    words = wire.command_words(RigCommand(np.array(voltages), air, reset))
    assert len(words) == wire.command_size
    back = wire.command(words)
    assert (back.air, back.reset) == (air, reset)
    for asked, given_ in zip(voltages, back.voltages.tolist(), strict=True):
        within = min(max(asked, 0.0), 10.0 - wire.voltage.lsb) if np.isfinite(asked) else 5.0
        assert abs(given_ - within) <= 0.5000001 * wire.voltage.lsb


def test_the_centre_is_met_exactly() -> None:
    for machine in ("paper-arm", "paper-small-joint", "paper-arm-switching"):
        described = load(machine)
        wire = Wire.for_machine(described)
        assert wire.voltage.value(wire.centre) == control(described).joints[0].null
        words = wire.command_words(RigCommand(np.array([nan] * wire.joints), air=False))
        assert words == wire.command_words(RigCommand(np.array([inf] * wire.joints), air=False))
        assert words[1:] == [wire.centre] * wire.joints


GRIPS = ARM.model_copy(update={"interface": ARM.interface.model_copy(update={"outputs": ("gripper", "lamp", "horn")})})


@given(st.integers(0, 7), st.booleans())
def test_digital_outputs_arrive_and_those_that_are_not_there_are_refused(outputs: int, air: bool) -> None:
    wire = Wire.for_machine(GRIPS)
    words = wire.command_words(RigCommand(np.array([5.0, 5.0]), air, outputs=outputs))
    assert wire.command(words)[1:] == (air, False, outputs)
    with pytest.raises(WireError, match="may be set"):
        wire.command([words[0] | 0x0800, *words[1:]])
    if outputs:
        with pytest.raises(WireError, match="may be set"):
            WIRES["12 bits"][1].command(words)


@given(st.lists(st.integers(0, 0xFFFF), max_size=12))
def test_any_words_are_refused_or_mean_just_what_they_say(words: list[int]) -> None:
    _, wire = WIRES["12 bits"]
    with suppress(WireError):
        assert wire.command_words(wire.command(words)) == words
    with suppress(WireError):
        assert wire.reading_words(wire.reading(words)) == words


@pytest.mark.parametrize(
    ("words", "what"),
    [
        ([0, 1, 2, 3], "6"),
        ([3, 0, 0, 0, 0, 0], "0x0003"),
        ([8, 0, 0, 0, 0, 0], "0x0008"),
        ([0, 0, 4097, 0, 0, 0], "4097"),
    ],
)
def test_readings_that_no_rig_gives(words: list[int], what: str) -> None:
    with pytest.raises(WireError, match=what):
        WIRES["12 bits"][1].reading(words)


def test_commands_that_no_host_gives() -> None:
    coarse = Wire.for_machine(changed(ARM, "interface.voltage_bits", 8))
    for words, what in (([0, 1], "2 words"), ([4, 0, 0], "0x0004"), ([1, 256, 0], "256")):
        with pytest.raises(WireError, match=what):
            coarse.command(words)


@given(half_ranges, bits, st.floats(-1.2, 1.2))
def test_a_sensors_number_comes_back_bit_for_bit(half: float, bits: int, share: float) -> None:
    sensor = Sensor(-half, half, 2 * half / 2**bits, 0.0, 0.0)
    reported = read_sensor(sensor, share * half, 0.0)
    converter = Converter.of_sensor(sensor)
    words: list[int] = []
    converter.append_count(words, reported)
    assert len(words) == converter.words
    assert all(0 <= word < 1 << 16 for word in words)
    assert converter.take(words, 0) == reported


@given(half_ranges, bits)
def test_both_ends_of_the_range_have_counts(half: float, bits: int) -> None:
    converter = Converter.of_sensor(Sensor(-half, half, 2 * half / 2**bits, 0.0, 0.0))
    assert converter.top == 2**bits
    assert converter.count(-2 * half) == 0
    assert converter.count(2 * half) == 2**bits
    assert converter.words == (1 if bits < 16 else 2)


@given(bits, st.integers(1, 1 << 30))
def test_a_count_that_no_converter_has_is_refused(bits: int, beyond: int) -> None:
    converter = Converter(0.0, 1.0, 2**bits)
    count = min(converter.top + beyond, (1 << 16 * converter.words) - 1)
    if count > converter.top:
        words = [count >> 16, count & 0xFFFF][-converter.words :]
        with pytest.raises(WireError, match=str(count)):
            converter.take(words, 0)


@given(numbers, st.integers(1, SEQUENCE_MODULUS // 2 - 1))
def test_what_follows_is_later_and_never_the_other_way_round(number: int, steps: int) -> None:
    later = (number + steps) % SEQUENCE_MODULUS
    assert is_later(later, number)
    assert not is_later(number, later)


@given(numbers)
def test_a_number_is_not_later_than_itself(number: int) -> None:
    assert not is_later(number, number)
    assert is_later(next_sequence(number), number)
    assert is_later(number, None)
