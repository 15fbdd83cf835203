"""Searches of inverse kinematics for a panel, called in a process beside its event loop; and where a tip may go."""

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.inverse import Inverse

ROWS = 61  # of the grid, and its columns


def reachable(inverse: Inverse, height: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return a grid of places at a height (m) in the frame of the base, and which of them the tip comes to.

    The grid is (rows, columns, 3), m; the flags are (rows, columns). Places are only looked for near mid-stroke.
    """
    low, high = inverse.tips.min(axis=0), inverse.tips.max(axis=0)
    x, y = np.linspace(low[0], high[0], ROWS), np.linspace(low[1], high[1], ROWS)
    corners = np.stack([*np.meshgrid(x, y), np.full((ROWS, ROWS), height)], axis=-1)
    found = inverse.near(corners.reshape(-1, 3), np.zeros(inverse.joints))
    return corners, found.there.reshape(ROWS, ROWS)


LONGEST_SEARCH = 5.0  # s
_known: list[tuple[Machine, Inverse]] = []
"""The machine that was searched last, and its inverse kinematics."""


def prepare(machine: Machine) -> None:
    """Load, and compile where need be, what searches call."""
    inverse = _inverse(machine)
    inverse.near(inverse.tips[:1], np.zeros(inverse.joints))


def find_posture(machine: Machine, place: Array, near: Array) -> Array:
    """Return angles (joints,), rad, near to others, with the tip of a machine at a place (axes,), m.

    Raises:
        InputError: as of `Inverse.posture`.
    """
    return _inverse(machine).posture(place, near, "tip")


def find_reachable(machine: Machine, height: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return what `reachable` returns for a machine and a height, m."""
    return reachable(_inverse(machine), height)


def _inverse(machine: Machine) -> Inverse:
    if not _known or _known[0][0] != machine:
        _known[:] = [(machine, Inverse(machine))]
    return _known[0][1]
