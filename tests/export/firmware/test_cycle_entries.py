"""Entries of a rig's cycle: their start is that of the rig's loop, and their tables are its settings."""

import ctypes
from typing import Any

import numpy as np
import pytest

from layflat.arrays import Array
from layflat.errors import MachineError
from layflat.export.firmware.cycle import CycleEntries
from layflat.lanes import leaves
from layflat.machine import load
from layflat.rig.driver import DeviceState, SensorReading

ARM = load("paper-arm")


def pointer(array: Array) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


@pytest.mark.parametrize("filled", [False, True])
@pytest.mark.parametrize("pressures", [(2e4, -3e4), (float("nan"), 1e5)])
def test_a_start_is_that_of_the_loop(filled: bool, pressures: tuple[float, float]) -> None:
    entries = CycleEntries(ARM)
    start, _ = entries
    supply, angles = 4.5e5, np.array([0.3, -0.2])
    numbers = [np.array(list(leaves(one)), float) for one in (entries.rig, entries.inputs, entries.samples)]
    numbers.append(np.array(list(leaves(entries.memory)), float))
    numbers[1][0] = supply
    numbers[2].reshape(2, -1)[:, :2] = np.column_stack([angles, pressures])
    start.function(*map(pointer, numbers), int(filled))
    core = entries.core
    core.initialize_air(SensorReading(angles, np.array(pressures), supply, False, DeviceState.RUNNING), filled=filled)
    core.freeze(angles)
    np.testing.assert_array_equal(numbers[3].reshape(2, -1), core.memory.array)


def test_tables_are_the_settings_of_the_loop() -> None:
    entries = CycleEntries(ARM)
    tables = {table.name: np.array(list(leaves(table.like)), float) for table in entries.tables()}
    core = entries.core
    np.testing.assert_array_equal(tables["rig_settings"], core.rig.array[0])
    np.testing.assert_array_equal(tables["cycle_settings"].reshape(2, -1), core.settings.array)
    np.testing.assert_array_equal(tables["law_settings"], entries.law.settings.array[0])
    np.testing.assert_array_equal(tables["arm_settings"], list(leaves(entries.arm)))


def test_a_machine_without_sensors_is_refused() -> None:
    with pytest.raises(MachineError, match="no valve or sensors"):
        CycleEntries(load("rig-kevlar"))
