"""Searches of inverse kinematics for a panel, called in its worker process: angles of a target, reachable positions."""

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.inverse import InverseKinematics

GRID_ROWS = 61  # and columns of the grid


def reachable_grid(inverse: InverseKinematics, height: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return a grid of positions at a height (m) in the base frame, and the mask of those that the tip reaches.

    The grid is (rows, columns, 3), m; the mask is (rows, columns). Searches begin at mid-stroke only.
    """
    low, high = inverse.tips.min(axis=0), inverse.tips.max(axis=0)
    x, y = np.linspace(low[0], high[0], GRID_ROWS), np.linspace(low[1], high[1], GRID_ROWS)
    corners = np.stack([*np.meshgrid(x, y), np.full((GRID_ROWS, GRID_ROWS), height)], axis=-1)
    solution = inverse.solve_near(corners.reshape(-1, 3), np.zeros(inverse.joints))
    return corners, solution.reached.reshape(GRID_ROWS, GRID_ROWS)


SEARCH_TIMEOUT = 5.0  # s
_known: list[tuple[Machine, InverseKinematics]] = []
"""Machine that was searched last, and its inverse kinematics."""


def prepare_search(machine: Machine) -> None:
    """Load and cache the inverse kinematics of a machine, and compile them where need be."""
    inverse = _inverse(machine)
    inverse.solve_near(inverse.tips[:1], np.zeros(inverse.joints))


def find_angles(machine: Machine, place: Array, near: Array) -> Array:
    """Return joint angles that bring the tip to a position, rad, (joints,).

    Args:
        machine: machine of the arm.
        place: position of the tip in the base frame, m, (2,) or (3,).
        near: angles from which the search begins, rad, (joints,).

    Raises:
        InputError: the position is out of reach, or reached by singular configurations alone.
    """
    return _inverse(machine).compute_configuration(place, near, "tip")


def find_reachable(machine: Machine, height: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return the `reachable_grid` of a machine at a height, m."""
    return reachable_grid(_inverse(machine), height)


def _inverse(machine: Machine) -> InverseKinematics:
    """Return the inverse kinematics of a machine, cached until another machine is searched."""
    if not _known or _known[0][0] != machine:
        _known[:] = [(machine, InverseKinematics(machine))]
    return _known[0][1]
