"""Limits of the joints of a rig, from the description of the machine: speeds and accelerations that demands may have.

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
from layflat.motion.limits import joint_capabilities
from layflat.motion.trajectory import QUINTIC_PEAKS, States, quintic

CONFIGURATIONS_PER_JOINT, MAX_CONFIGURATIONS = 5, 4096  # sampled of each joint, and in all: of many joints fewer each
MIN_TORQUE_FRACTION = 0.1  # fraction of its torque that a joint is assumed to have left at least, against gravity
REFERENCE_MOVE = np.radians(40.0)  # L: the paper's moves
STOP_COMPRESSION_FACTOR = 2.0  # greatest compression of a stop over the torque of gravity by its stiffness
CENTRED_VENT_FACTOR = 5.0  # time in which hoses empty through centred, dithering valves over that through open ones
UNIFORM_HALF_WIDTH = sqrt(3.0)  # half the width of a uniform distribution, in standard deviations


class DemandLimits(NamedTuple):
    """Limits of the demands of each joint, (joints,)."""

    speed: Array  # rad/s
    acceleration: Array  # greatest in any configuration, all joints helping, rad/s2
    braking: Array  # deceleration available in every configuration, all joints braking at once, rad/s2
    pace: Array  # mean speed of a move in the worst configuration, rad/s
    resting: Array  # greatest deceleration by friction alone in any configuration, rad/s2


def payload_range(machine: Machine) -> tuple[float, float]:
    """Return the smallest and the greatest payload, kg, that the machine's control law may meet.

    A law with a `payload_std` above 0 meets all payloads from none up to the upper end of a uniform distribution of
    that standard deviation around the described one; with a spread of 0 it meets the described one alone. A law without
    that setting meets all from none to the described one.
    """
    described = machine.arm.payload
    spread = getattr(machine.controller, "payload_std", None)
    if spread is None:
        return 0.0, described
    return (0.0, described + UNIFORM_HALF_WIDTH * spread) if spread > 0.0 else (described, described)


def sample_configurations(machine: Machine) -> Array:
    """Return a grid over the working strokes, their ends included, (configurations, joints), rad; up to 5 a joint."""
    halves = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
    n = len(halves)
    each = next((count for count in range(CONFIGURATIONS_PER_JOINT, 2, -1) if count**n <= MAX_CONFIGURATIONS), 2)
    return np.array(list(product(*(np.linspace(-half, half, each) for half in halves))))


def demand_limits(machine: Machine) -> DemandLimits:
    """Return the limits of each joint's demands (see `DemandLimits`) over all payloads and sampled configurations.

    No configuration exceeds sum_i |(M^-1)_ji| T_i. A move by L accelerates over half of its path and brakes over the
    other half; before each the torque builds up. Against gravity and friction a joint counts as having at least
    `MIN_TORQUE_FRACTION` of its torque left for braking.

    Raises:
        MachineError: the machine has no valves.
    """
    able, arm, configurations = joint_capabilities(machine), parameters.arm(machine), sample_configurations(machine)
    friction, max_acceleration = able.friction + able.loss, np.zeros(1)
    min_braking, max_resting = np.array(inf), np.zeros(1)
    for payload in dict.fromkeys(payload_range(machine)):
        mass, gravity = parameters.mass_and_pull(arm, payload, configurations)
        pull = np.abs(gravity)
        mobility = np.abs(np.linalg.inv(mass))
        acceleration = _multiply(mobility, able.torque + friction + pull).max(axis=0)
        max_acceleration = np.maximum(max_acceleration, acceleration)
        max_resting = np.maximum(max_resting, np.diagonal(mobility, axis1=1, axis2=2).max(axis=0) * friction)
        # All joints at once, with any signs: each alone, reduced by the inertia that couples them.
        torque = np.maximum(able.torque - friction - pull, MIN_TORQUE_FRACTION * able.torque)
        alone = torque / np.diagonal(mass, axis1=1, axis2=2)
        together = alone * np.min(torque / _multiply(np.abs(mass), alone), axis=1, keepdims=True)
        min_braking = np.minimum(min_braking, together.min(axis=0))
    move_time = 2.0 * np.sqrt(REFERENCE_MOVE / min_braking) + 2.0 * able.torque / able.rate
    return DemandLimits(able.speed, max_acceleration, min_braking, REFERENCE_MOVE / move_time, max_resting)


def max_gravity_torques(machine: Machine) -> Array:
    """Return the greatest absolute torque of gravity and springs on each joint, (joints,), N m.

    It is the maximum over both ends of the payload range and all sampled configurations.
    """
    arm, configurations = parameters.arm(machine), sample_configurations(machine)
    pulls = [parameters.mass_and_pull(arm, payload, configurations)[1] for payload in payload_range(machine)]
    greatest: Array = np.abs(pulls).max(axis=(0, 1))
    return greatest


def find_sinking_joints(machine: Machine) -> NDArray[np.bool_]:
    """Return a mask, (joints,), True where gravity and springs exceed a joint's friction in some configuration.

    Raises:
        MachineError: the machine has no valves.
    """
    sinking: NDArray[np.bool_] = max_gravity_torques(machine) > joint_capabilities(machine).friction
    return sinking


def falls_without_air(machine: Machine) -> bool:
    """Return whether the arm falls if its hoses are emptied at once: whether any of its joints sinks.

    The valves of such an arm stay centred while it is vented: the leakage through their dithering spools lowers it
    slowly.

    Raises:
        MachineError: the machine has no valves.
    """
    return bool(find_sinking_joints(machine).any())


def vent_time(machine: Machine) -> float:
    """Return the time allowed for venting the hoses, s.

    It is `safety.vent_time`, times `CENTRED_VENT_FACTOR` for an arm that falls without air.

    Raises:
        MachineError: the machine has no valves.
    """
    return machine.safety.vent_time * (CENTRED_VENT_FACTOR if falls_without_air(machine) else 1.0)


def may_reach_stops(machine: Machine, angles: Sequence[float], velocities: Sequence[float], torques: Array) -> bool:
    """Return whether an arm in motion may reach a mechanical stop once its valves no longer obey.

    It may where its kinetic energy, with the greatest payload, exceeds the work of friction, less that of the hoses, in
    any one joint up to its stop. Sinking joints reach their stops in any case and are left out.

    Args:
        machine: the machine.
        angles: rad, (joints,).
        velocities: rad/s, (joints,).
        torques: torques of the hoses, N m, (joints,).

    Raises:
        MachineError: the machine has no valves.
    """
    able, v, held = joint_capabilities(machine), np.array(velocities), ~find_sinking_joints(machine)
    mass, _ = parameters.mass_and_pull(parameters.arm(machine), payload_range(machine)[1], angles)
    stops = np.array([0.5 * joint.stops.mechanical_stroke for joint in machine.joints.values()])
    distance = np.maximum(stops - np.abs(angles), 0.0)
    absorbed = (able.friction + able.loss - np.abs(torques)) * distance
    return bool(0.5 * v @ mass @ v > np.min(absorbed[held], initial=inf))


def resting_angles(machine: Machine) -> Array:
    """Return the greatest angles from mid-stroke at which joints may rest without air, (joints,), rad.

    These are the mechanical stops with their compression: of a joint that sinks, `STOP_COMPRESSION_FACTOR` times that
    by the greatest torque of gravity (`max_gravity_torques`); of any other, what its friction can hold against the
    stop.

    Raises:
        MachineError: the machine has no valves.
    """
    stops = [joint.stops for joint in machine.joints.values()]
    ends = np.array([0.5 * stop.mechanical_stroke for stop in stops])
    presses = np.where(
        find_sinking_joints(machine),
        STOP_COMPRESSION_FACTOR * max_gravity_torques(machine),
        joint_capabilities(machine).friction,
    )
    resting: Array = ends + presses / np.array([stop.stop_stiffness for stop in stops])
    return resting


def _multiply(matrices: Array, vectors: Array) -> Array:
    """Return products of matrices (..., joints, joints) and vectors, (..., joints)."""
    through: Array = (matrices @ vectors[..., None])[..., 0]
    return through


def plan_smooth_motion(
    machine: Machine, start: Array, end: Array, fraction: float, limits: DemandLimits | None = None
) -> States:  # fmt: skip
    """Return a motion from rest to rest by a polynomial of fifth degree: (cycles, joints) each, a row a control cycle.

    Args:
        machine: machine whose joints move.
        start: angles, rad, (joints,).
        end: angles, rad, (joints,).
        fraction: 0..1, of the speed and acceleration that the arm has in every configuration, used at most.
        limits: limits of the machine's demands; computed where they are not passed, which takes 10 ms, and raises
            MachineError for a machine without valves.
    """
    limits, distance = limits or demand_limits(machine), np.abs(end - start)
    by_speed = QUINTIC_PEAKS[0] * distance / (fraction * limits.speed)
    by_acceleration = np.sqrt(QUINTIC_PEAKS[1] * distance / (fraction * limits.braking))
    T = max(float(np.maximum(by_speed, by_acceleration).max()), machine.cycle)
    position, speed, acceleration = quintic(np.arange(0.0, T + machine.cycle, machine.cycle)[:, None] / T)
    L = end - start
    return States(start + L * position, L * speed / T, L * acceleration / T**2)
