"""The members of a cloud as machines, and as numbers in place of a machine's own."""

from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.machine.cloud import PAPER, cloud
from layflat.machine.loader import load


def members(where: str, path: Path = PAPER) -> list[str]:
    """Return the names of a machine's members, in the order of the cloud that a file keeps.

    Raises:
        MachineError: the file is no cloud, or of another version.
    """
    at = "" if path == PAPER else f"{path}:"
    return [f"{where}@{at}{number}" for number in range(len(cloud(path).members))]


def differing(where: str, path: Path = PAPER) -> dict[str, Array]:
    """Return the numbers (SI) in which a machine's members differ, by dotted path: all but gains, an item a member.

    Raises:
        MachineError: the file is no cloud of this machine.
    """
    machines = [load(name) for name in members(where, path)]
    found = {}
    for column in cloud(path).columns:
        for key in (key for key in column.paths if ".gains." not in key):
            try:
                numbers = np.array([value_at(machine, key) for machine in machines], dtype=float)
            except InputError:  # of a joint that it does not have
                continue
            if np.ptp(numbers) > 0.0:
                found[key] = numbers
    return found
