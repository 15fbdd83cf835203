"""How fast the joints of a rig can be, from the description of the machine: what demands may ask for.

| symbol | meaning | unit |
|---|---|---|
| M | mass matrix of the arm with its payload | kg m2 |
| T_i | torque of full hoses against empty ones, and what friction and gravity add to it | N m |
| L | angle of a move | rad |
"""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.motion.limits import abilities

POSTURES = 5  # looked at of each joint
LEAST = 0.1  # share of its torque that a joint is taken to have at least, against gravity
MOVE = np.radians(40.0)  # L: the paper's moves


class DemandLimits(NamedTuple):
    """Of each joint, (joints,)."""

    speed: Array  # rad/s
    acceleration: Array  # that no posture exceeds, all joints helping, rad/s2
    braking: Array  # that every posture has, all joints braking at once, rad/s2
    pace: Array  # mean speed of a move in the worst posture, rad/s


def demand_limits(machine: Machine) -> DemandLimits:
    """Return how fast demands may be; raise MachineError if the machine has no valves.

    No posture exceeds sum_i |(M^-1)_ji| T_i. A move by L accelerates half of its way, and brakes the other half; before
    each the torque builds up.
    """
    able, n = abilities(machine), len(machine.joints)
    arm = parameters.arm(machine)
    opposes = able.friction + able.loss
    most, least = np.zeros(n), np.full(n, np.inf)
    halves = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
    for angles in product(*(np.linspace(-half, half, POSTURES) for half in halves)):
        mass, gravity = parameters.mass_and_pull(arm, machine.arm.payload, angles)
        pull = np.abs(gravity)
        most = np.maximum(most, np.abs(np.linalg.inv(mass)) @ (able.torque + opposes + pull))
        # All at once, whatever their signs: each alone, over what the inertia between them makes of it.
        torque = np.maximum(able.torque - opposes - pull, LEAST * able.torque)
        alone = torque / mass.diagonal()
        least = np.minimum(least, alone * np.min(torque / (np.abs(mass) @ alone)))
    move = 2.0 * np.sqrt(MOVE / least) + 2.0 * able.torque / able.rate
    return DemandLimits(able.speed, most, least, MOVE / move)


def swings_on(machine: Machine, angles: Sequence[float], velocities: Sequence[float], torques: Array) -> bool:
    """Whether an arm in motion (rad, rad/s) may reach a mechanical stop once its valves no longer obey.

    So it is where its kinetic energy, with the work that the hoses' torques (N m) may do until they are empty, is more
    than what friction takes up in one of its joints before the stop.
    """
    able, v = abilities(machine), np.array(velocities)
    mass, _ = parameters.mass_and_pull(parameters.arm(machine), machine.arm.payload, angles)
    stops = np.array([0.5 * joint.stops.mechanical_stroke for joint in machine.joints.values()])
    way = np.maximum(stops - np.abs(angles), 0.0)
    return bool(0.5 * v @ mass @ v > np.min((able.friction + able.loss - np.abs(torques)) * way))
