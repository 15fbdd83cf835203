"""Any number of a machine may be an array, an item a run: its parameters are then those of the single machines."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from layflat.description.change import paths, value_at
from layflat.errors import InputError
from layflat.lanes import leaves
from layflat.machine import Machine, changed, load, parameters

FACTORS = np.array([0.93, 1.0, 1.04])
MACHINES = ("paper-arm", "paper-small-joint", "paper-arm-switching")

FIXED = ("interface", "controller.cycle")
"""What is the same in all runs."""


def varied(name: str) -> list[tuple[str, Machine]]:
    """Paths of a machine, and the machine with an array there, for numbers that may vary."""
    machine, found = load(name), []
    for path in paths(machine):
        if not path.startswith(FIXED) and not isinstance(value_at(machine, path), int):
            with suppress(InputError):  # such as weights, which add up to one
                found.append((path, changed(machine, path, value_at(machine, path) * FACTORS)))
    return found


def numbers(machine: Machine) -> list[Any]:
    """All parameters of the laws."""
    settings = parameters.control(machine)
    return list(
        leaves((parameters.arm(machine), parameters.joints(machine), settings, parameters.surroundings(machine)))
    )


@pytest.mark.parametrize("name", MACHINES)
def test_arrays_give_what_each_of_their_items_gives(name: str) -> None:
    machine = load(name)
    base, decides = np.array(numbers(machine)), set[str]()
    for path, many in varied(name):
        together = numbers(many)
        each = [np.array(numbers(changed(machine, path, float(one)))) for one in value_at(many, path)]
        for i, one in enumerate(each):
            found = np.array([float(np.broadcast_to(number, 3)[i]) for number in together])
            assert found == pytest.approx(one, rel=1e-12, abs=0.0), path
            if not np.array_equal(one, base):
                decides.add(path)
    for path in ("valve.conductance", "joint.small.brake.torque", "supply.pressure_gauge", "arm.payload"):
        assert path in decides


@pytest.mark.parametrize("name", MACHINES)
def test_only_what_a_number_decides_becomes_an_array(name: str) -> None:
    machine = load(name)
    for path in ("joint.small.brake.torque", "arm.payload", "supply.temperature"):
        value = value_at(machine, path)
        before, after = numbers(machine), numbers(changed(machine, path, value * FACTORS))
        arrays = [i for i, number in enumerate(after) if np.ndim(number)]
        assert len(arrays) == 1
        assert after[arrays[0]] == pytest.approx(before[arrays[0]] * FACTORS)
        assert [number for i, number in enumerate(after) if i not in arrays] == [
            number for i, number in enumerate(before) if i not in arrays
        ]
