"""Sets of machines from which episodes take theirs."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Protocol

import numpy as np

from layflat.arrays import Array
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.machine.exchanged import member_values
from layflat.tune.robust import PlantGroup, robust_plant_groups


class MachineSet(Protocol):
    """Function that draws machines of one structure around a described one."""

    def __call__(self, machine: Machine, count: int, seed: int) -> PlantGroup:
        """Return a machine, and the values in which `count` others differ from it, by key."""


def _nominal(machine: Machine, count: int, seed: int) -> PlantGroup:  # noqa: ARG001  # a machine set
    """Return the machine as described."""
    return PlantGroup(machine, {})


def _cloud(machine: Machine, count: int, seed: int) -> PlantGroup:
    """Return members of the paper's cloud; raise MachineError if it has no values of the machine."""
    values = member_values(machine.origin)
    drawn = np.random.default_rng(seed).integers(max((len(each) for each in values.values()), default=1), size=count)
    return PlantGroup(machine, {key: each[drawn] for key, each in values.items()})


def _robust(machine: Machine, count: int, seed: int) -> PlantGroup:
    """Return machines of the robust set with the machine's own law of losses."""
    return robust_plant_groups(machine, 2 * count, seed=seed)[0]


def _bouc_wen(machine: Machine, count: int, seed: int) -> PlantGroup:
    """Return machines of the robust set with Bouc and Wen's law of losses."""
    return robust_plant_groups(machine, 2 * count, seed=seed)[1]


MACHINE_SETS: Mapping[str, MachineSet] = MappingProxyType(
    {"nominal": _nominal, "cloud": _cloud, "robust": _robust, "bouc-wen": _bouc_wen}
)
"""Sets of machines by name."""

MOVED_BY_GEOMETRY = frozenset({"arm.elbow"})
"""Keys of machines whose tips are elsewhere at the same angles."""


def draw_machines(machine: Machine, name: str, count: int, seed: int) -> PlantGroup:
    """Return machines of a set.

    Args:
        machine: the described machine.
        name: key of `MACHINE_SETS`.
        count: number of machines.
        seed: seed of the draw.

    Raises:
        InputError: there is no such set, or not of this machine.
    """
    if name not in MACHINE_SETS:
        raise InputError(
            f"{shown(name)} is no set of machines", where="machines", right=f"use {', '.join(MACHINE_SETS)}"
        )
    return MACHINE_SETS[name](machine, count, seed)


def have_equal_geometry(vary: Mapping[str, Array]) -> bool:
    """Return whether the tips of all machines are at the same place at the same angles."""
    return not MOVED_BY_GEOMETRY & vary.keys()
