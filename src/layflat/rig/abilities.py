"""How fast the joints of a rig can be, from the description of the machine: what demands may ask for.

| symbol | meaning | unit |
|---|---|---|
| M | mass matrix of the arm with its payload | kg m2 |
| T_i | torque of full hoses against empty ones, and what friction and gravity add to it | N m |
| L | angle of a move | rad |
"""

from collections.abc import Sequence
from itertools import product
from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.motion.limits import Ability, abilities

POSTURES, MOST = 5, 4096  # looked at of each joint, and in all: of many joints fewer each
LEAST = 0.1  # share of its torque that a joint is taken to have at least, against gravity
MOVE = np.radians(40.0)  # L: the paper's moves
GIVES_WAY = 2.0  # times the torque of gravity over the stiffness of a stop: how far a joint may be pressed in
SLOWLY = 5.0  # times as long hoses take to empty through valves that are centred and dither, than through open ones
EVEN = sqrt(3.0)  # half the width of an even spread, in standard deviations


class DemandLimits(NamedTuple):
    """Of each joint, (joints,)."""

    speed: Array  # rad/s
    acceleration: Array  # that no posture exceeds, all joints helping, rad/s2
    braking: Array  # that every posture has, all joints braking at once, rad/s2
    pace: Array  # mean speed of a move in the worst posture, rad/s
    resting: Array  # deceleration by friction alone, where the arm is lightest to a joint, rad/s2


def payloads(machine: Machine) -> tuple[float, float]:
    """Return the least and the greatest payload, kg, that the machine's control law may meet.

    One that is told how far the payload may differ from the described meets all from none on, up to the end of an even
    spread of that deviation; one that is told that it is known only this. Any other goes by errors.
    """
    described = machine.arm.payload
    spread = getattr(machine.controller, "payload_spread", None)
    if spread is None:
        return 0.0, described
    return (0.0, described + EVEN * spread) if spread > 0.0 else (described, described)


def postures(machine: Machine) -> Array:
    """Return a grid of postures within the working strokes, (postures, joints), rad."""
    halves = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
    n = len(halves)
    each = next((count for count in range(POSTURES, 2, -1) if count**n <= MOST), 2)
    return np.array(list(product(*(np.linspace(-half, half, each) for half in halves))))


def demand_limits(machine: Machine, able: Ability | None = None) -> DemandLimits:
    """Return how fast demands may be, whatever the payload; raise MachineError if the machine has no valves.

    No posture exceeds sum_i |(M^-1)_ji| T_i. A move by L accelerates half of its way, and brakes the other half; before
    each the torque builds up. `able`: what the joints can do, where that is known.
    """
    able, arm, places = able or abilities(machine), parameters.arm(machine), postures(machine)
    opposes, most, least, rests = able.friction + able.loss, np.zeros(1), np.array(inf), np.zeros(1)
    for payload in dict.fromkeys(payloads(machine)):
        mass, gravity = parameters.mass_and_pull(arm, payload, places)
        pull = np.abs(gravity)
        gives = np.abs(np.linalg.inv(mass))
        most = np.maximum(most, _through(gives, able.torque + opposes + pull).max(axis=0))
        rests = np.maximum(rests, np.diagonal(gives, axis1=1, axis2=2).max(axis=0) * opposes)
        # All at once, whatever their signs: each alone, over what the inertia between them makes of it.
        torque = np.maximum(able.torque - opposes - pull, LEAST * able.torque)
        alone = torque / np.diagonal(mass, axis1=1, axis2=2)
        together = alone * np.min(torque / _through(np.abs(mass), alone), axis=1, keepdims=True)
        least = np.minimum(least, together.min(axis=0))
    move = 2.0 * np.sqrt(MOVE / least) + 2.0 * able.torque / able.rate
    return DemandLimits(able.speed, most, least, MOVE / move, rests)


def pulls(machine: Machine) -> Array:
    """Return the greatest torque of gravity and springs on each joint, whatever posture and payload, (joints,), N m."""
    arm, places = parameters.arm(machine), postures(machine)
    found = [parameters.mass_and_pull(arm, payload, places)[1] for payload in payloads(machine)]
    most: Array = np.abs(found).max(axis=(0, 1))
    return most


def sinks(machine: Machine) -> NDArray[np.bool_]:
    """Return which joints their brakes do not hold against gravity, in some posture and with some payload, (joints,).

    Raise MachineError if the machine has no valves.
    """
    found: NDArray[np.bool_] = pulls(machine) > abilities(machine).friction
    return found


def falls(machine: Machine) -> bool:
    """Whether the arm falls if its hoses are emptied at once: then its valves stay centred while the air is let out.

    What they pass as they dither lets it down slowly. Raise MachineError if the machine has no valves.
    """
    return bool(sinks(machine).any())


def vent_time(machine: Machine) -> float:
    """Return the time in which the hoses empty, s; raise MachineError if the machine has no valves."""
    return machine.safety.vent_time * (SLOWLY if falls(machine) else 1.0)


def swings_on(machine: Machine, angles: Sequence[float], velocities: Sequence[float], torques: Array) -> bool:
    """Whether an arm in motion (rad, rad/s) may reach a mechanical stop once its valves no longer obey.

    So it is where its kinetic energy, with the work that the hoses' torques (N m) may do until they are empty, is more
    than what friction takes up in one of its joints before the stop. Joints that sink reach theirs in any case.
    """
    able, v, held = abilities(machine), np.array(velocities), ~sinks(machine)
    mass, _ = parameters.mass_and_pull(parameters.arm(machine), payloads(machine)[1], angles)
    stops = np.array([0.5 * joint.stops.mechanical_stroke for joint in machine.joints.values()])
    way = np.maximum(stops - np.abs(angles), 0.0)
    takes = (able.friction + able.loss - np.abs(torques)) * way
    return bool(0.5 * v @ mass @ v > np.min(takes[held], initial=inf))


def resting_angles(machine: Machine) -> Array:
    """Return how far from mid-stroke joints may rest without air, (joints,), rad.

    That is their mechanical stops, which give way where gravity presses a joint into them, or its brake keeps it there.
    Raise MachineError if the machine has no valves.
    """
    stops = [joint.stops for joint in machine.joints.values()]
    ends = np.array([0.5 * stop.mechanical_stroke for stop in stops])
    presses = np.where(sinks(machine), GIVES_WAY * pulls(machine), abilities(machine).friction)
    resting: Array = ends + presses / np.array([stop.stop_stiffness for stop in stops])
    return resting


def _through(matrices: Array, vectors: Array) -> Array:
    # (..., joints) of (..., joints, joints) and (..., joints).
    through: Array = (matrices @ vectors[..., None])[..., 0]
    return through
