from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat import changed, load
from layflat.errors import InputError, MachineError
from layflat.rig.driver import Capabilities, DriverError
from layflat.rig.wire import IDENTITY_MAGIC, IDENTITY_SIZE, Identity, Registers, WireError

ARM = load("paper-arm")
ABLE = Capabilities(2, 0.0, 10.0, 5.0, True, 1e-3)


def test_a_far_side_of_the_same_machine_fits() -> None:
    told = Identity.from_words(Identity.for_machine(ARM, ABLE).words())
    assert told.check(ARM, "here") == ABLE


def test_a_device_has_as_many_digital_outputs_as_the_machine_or_more() -> None:
    grips = ARM.model_copy(update={"interface": ARM.interface.model_copy(update={"outputs": ("gripper", "lamp")})})
    with pytest.raises(DriverError, match=r"the rig has 1 digital output\(s\), the machine 'paper-arm' 2"):
        Identity.for_machine(grips, ABLE._replace(outputs=1)).check(grips, "here")
    able = ABLE._replace(outputs=3)
    assert Identity.from_words(Identity.for_machine(grips, able).words()).check(grips, "here") == able
    with pytest.raises(InputError, match="it has 0 digital outputs, the machine 2"):
        ABLE.check(grips)


def test_negative_voltages_come_back() -> None:
    machine = changed(ARM, "valve.centre_voltage", -1.0)
    able = ABLE._replace(voltage_low=-6.0, voltage_high=4.0, centre_voltage=-1.0)
    assert Identity.from_words(Identity.for_machine(machine, able).words()).check(machine, "here") == able


@pytest.mark.parametrize(
    ("path", "value", "what"),
    [
        (
            "valve.centre_voltage",
            0.0,
            "the rig has voltages from 0 mV on, the machine 'paper-arm' voltages from -5000 mV",
        ),
        ("interface.voltage_bits", 12, "voltages of 16 bits"),
        ("angle_sensor.bits", 14, "angles of 12 bits"),
        ("pressure_sensor.bits", 14, "pressures of 12 bits"),
        ("interface.supply_bits", 10, "a supply of 12 bits"),
        ("interface.watchdog_cycles", 6, "a watchdog of 20 ms, the machine 'paper-arm' a watchdog of 30 ms"),
        ("interface.dump_after", 0.5, "200 ms until it dumps"),
    ],
)
def test_a_far_side_of_another_machine_is_told_by_what_differs(path: str, value: float, what: str) -> None:
    with pytest.raises(DriverError) as error:
        Identity.for_machine(ARM, ABLE).check(changed(ARM, path, value), "serial:///dev/rig")
    assert what in str(error.value)
    assert str(error.value).startswith("serial:///dev/rig: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("able", "what"),
    [
        (ABLE._replace(joints=3), "3 joint"),
        (ABLE._replace(dithers=False), "no dither"),
        (ABLE._replace(shortest_cycle=8e-3), "8000 us a cycle"),
    ],
)
def test_a_far_side_that_can_do_too_little_is_refused(able: Capabilities, what: str) -> None:
    with pytest.raises(DriverError, match=what):
        Identity.for_machine(ARM, able).check(ARM, "here")


def test_valves_that_switch_need_no_dither() -> None:
    machine = load("paper-arm-switching")
    found = Identity.for_machine(machine, ABLE._replace(dithers=False)).check(machine, "here")
    assert not found.dithers


@given(st.lists(st.integers(0, 0xFFFF), max_size=20))
def test_whatever_else_answers_is_no_rig(words: list[int]) -> None:
    with pytest.raises(WireError, match="not a rig"):
        Identity.from_words(words)


def test_another_version_is_told() -> None:
    with pytest.raises(WireError, match="version 9"):
        Identity.from_words([IDENTITY_MAGIC, 9, *range(IDENTITY_SIZE - 2)])


def test_machines_that_are_no_rigs() -> None:
    with pytest.raises(MachineError, match="no valve or sensors"):
        Identity.for_machine(load("rig-kevlar"))
    with pytest.raises(MachineError, match="32 V"):
        Identity.for_machine(changed(ARM, "valve.centre_voltage", 30.0))


def test_the_map_that_the_docs_show() -> None:
    found = Registers.for_machine(ARM)
    assert found == (range(4), range(7), range(256, 270))


@pytest.mark.parametrize(
    ("path", "value", "what"),
    [
        ("interface.modbus.readings", 65530, "7 registers from 65530 on go beyond 65535"),
        ("interface.modbus.commands", 65533, "4 registers from 65533 on"),
        ("interface.modbus.identity", 5, "register 5 is too near to the readings"),
    ],
)
def test_maps_that_can_not_be(path: str, value: int, what: str) -> None:
    with pytest.raises(MachineError, match=what) as error:
        Registers.for_machine(changed(ARM, path, value))
    assert path in str(error.value)


def test_a_cycle_that_no_word_carries_is_told() -> None:
    with pytest.raises(MachineError, match="shortest cycle is too long for a rig's wire; rigs have cycles up to 65 ms"):
        Identity.for_machine(changed(ARM, "controller.cycle", 0.07))


@pytest.mark.parametrize(("name", "value"), [("shortest_cycle", 70000), ("joints", -1), ("voltage_low", -40000)])
def test_no_number_goes_out_as_another(name: str, value: int) -> None:
    with pytest.raises(WireError, match=f"{name} is {value}, which does not fit into a word"):
        Identity.for_machine(ARM, ABLE)._replace(**{name: value}).words()
