"""Demands by the place of the tip, as angles of the joints."""

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.inverse import Inverse
from layflat.motion.kinematics import tip_position
from layflat.motion.path import CLOSE


def axes_of(machine: Machine) -> list[str]:
    """Return the axes along which the tip of a machine's arm has coordinates: x and y, in space z too."""
    return list("xyz")[: tip_position(machine, np.zeros(len(machine.joints))).shape[-1]]


def demand_of_tip(machine: Machine, places: Array, near: Array, where: str) -> Array:
    """Return angles (instants, joints), rad, that bring the tip to places (instants, axes), m.

    Each posture is near to the one before it, the first to `near` (joints,), rad.

    Raises:
        InputError: naming `where`: a place is out of reach, or singular postures alone get there.
    """
    inverse, before, angles = Inverse(machine), near, np.empty((len(places), len(machine.joints)))
    last = tip_position(machine, near)
    for k, place in enumerate(places):
        if np.linalg.norm(place - last) > CLOSE:
            before, last = inverse.posture(place, before, where), place
        angles[k] = before
    return angles
