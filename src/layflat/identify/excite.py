"""Excitation sequence for identification: demands for a machine's controller while a log is recorded.

Steps fill and vent with the valve wide open; chirps excite inertia, lag and delay; slow ramps in both directions show
friction and losses; small moves show the flow about the valve's centre; pauses show leakage and heat. The first two
thirds hold all of them, to be fitted; the last third repeats them with other amplitudes, for validation.

All joints move at the same time, so that the log of an arm shows their coupling. Accelerations are limited to those
that all joints have together in the worst configuration of the sequence, with the payload, against gravity.
"""

from collections.abc import Callable

import numpy as np
from scipy.signal import chirp

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.dynamics import torque_margin_at_rest
from layflat.motion.limits import joint_capabilities, simultaneous_accelerations

DEFAULT_REACH = 0.3  # largest angle from the middle, as a fraction of the working stroke
MIN_REACH = 0.02  # the same, smallest that is useful
SPEED = 5.0  # limit of the demand's rate, rad/s: steps are ramps that a valve wide open follows
ACCELERATION_FRACTION = 0.5  # of the accelerations that all joints have at once
MIN_RISE_TIME = 0.1  # s, of the demand's rate from zero to its limit: at 0.05 s light joints are thrown about
MIN_TORQUE_RESERVE = 0.2  # of a joint's torque, left over for motion where gravity, friction and losses are greatest
CONFIGURATION_INTERVAL = 0.2  # between configurations in which accelerations are computed, s
REACH_STEPS = 10  # fractions of the reach that are tried where it is too large
FIT_DURATION, VALIDATION_DURATION = 28.0, 14.0  # s


def _step_levels(t: Array, duration: float, random: np.random.Generator) -> Array:
    """Return levels -1 to 1 in random order, then 0, each held about 0.9 s: fractions of the reach at times t (s)."""
    count = max(3, round(duration / 0.9))
    levels = np.append(random.permutation(np.linspace(-1.0, 1.0, count - 1)), 0.0)
    return np.asarray(levels[np.minimum((count * t / duration).astype(int), count - 1)])


def _chirp_levels(t: Array, duration: float, random: np.random.Generator) -> Array:
    """Return a swept sine from 0.3 to 3 Hz with a random amplitude of 0.24 to 0.36 of the reach."""
    swept = chirp(t, 0.3, duration, 3.0, method="logarithmic", phi=-90)
    return np.asarray(0.3 * random.uniform(0.8, 1.2) * swept)


def _ramp_levels(t: Array, duration: float, random: np.random.Generator) -> Array:
    """Return ramps of one speed to 0.9 and 0.45 of the reach, to both sides, and to 0; the first side is random."""
    corners = np.array([0.0, 0.9, -0.9, 0.45, -0.45, 0.0]) * random.choice([-1.0, 1.0])
    ways = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)))])
    return np.asarray(np.interp(t / duration, ways / ways[-1], corners))


def _small_step_levels(t: Array, duration: float, random: np.random.Generator) -> Array:
    """Return equally long steps to 0.1 and 0.04 of the reach, to both sides, then to 0; the first side is random."""
    levels = np.array([0.1, -0.1, 0.04, -0.04, 0.0]) * random.choice([-1.0, 1.0])
    return np.asarray(levels[np.minimum((len(levels) * t / duration).astype(int), len(levels) - 1)])


SEQUENCE_PARTS: tuple[tuple[float, Callable[..., Array]], ...] = (
    (0.05, lambda t, *_: np.zeros_like(t)),
    (0.26, _step_levels),
    (0.25, _chirp_levels),
    (0.3, _ramp_levels),
    (0.14, _small_step_levels),
)
"""Fraction of the duration of each part; and its levels, fractions of the reach, by times (s), duration, generator."""


def plan_sequence(
    machine: Machine, *, reach: float = DEFAULT_REACH, speed: float = SPEED, seed: int = 0
) -> tuple[Array, Array]:
    """Return the times and demands of an excitation sequence for a machine's controller.

    Args:
        machine: machine to be excited.
        reach: largest angle from the middle, as a fraction of the working stroke, 0.02 to 0.45.
        speed: limit of the demand's rate, rad/s.
        seed: seed of amplitudes and order, which differ from joint to joint.

    Returns:
        Times, s, (cycles,), and demands, rad from the middle of the stroke, (cycles, joints): 28 s to be fitted, then
        14 s for validation.

    Raises:
        InputError: the machine has no controller with gains, can't hold itself against gravity, or an argument is out
            of range.
    """
    lacking = machine.control_law.gains is not None and any(joint.gains is None for joint in machine.joints.values())
    if machine.controller is None or lacking:
        where = f"{machine.origin}: controller"
        raise InputError("has no gains to follow a sequence with", where=where, right="tune it first: `layflat tune`")
    if not MIN_REACH <= reach <= 0.45:
        raise InputError(
            f"{reach:g} is out of range", where="reach", right="give a fraction of the stroke, 0.02 to 0.45"
        )
    if not speed > 0.0:
        raise InputError(f"{speed:g} rad/s is out of range", where="speed", right='give more than zero: "300 deg/s"')
    cycle = machine.controller.cycle
    strokes = np.array([joint.stops.working_stroke for joint in machine.joints.values()])
    joints = range(len(strokes))
    levels = [
        np.concatenate(
            [_sequence_levels(FIT_DURATION, cycle, seed, j), _sequence_levels(VALIDATION_DURATION, cycle, seed, j, 1)]
        )
        for j in joints
    ]
    targets = strokes * np.stack(levels, axis=1)
    acceleration = np.minimum(
        _joint_accelerations(machine, targets[:: round(CONFIGURATION_INTERVAL / cycle)], reach), speed / MIN_RISE_TIME
    )
    demand = _limit_motion(reach * targets, speed, acceleration, cycle)
    return np.asarray(cycle * np.arange(len(demand)), dtype=np.float64), demand


def _joint_accelerations(machine: Machine, configurations: Array, reach: float) -> Array:
    """Return `ACCELERATION_FRACTION` of what all joints reach together in the worst configuration, rad/s2, (joints,).

    Args:
        machine: machine with its payload.
        configurations: joint angles for a reach of 1, rad, (configurations, joints).
        reach: factor of these angles.

    Raises:
        InputError: in one of them a joint has less than `MIN_TORQUE_RESERVE` of its torque left for motion.
    """
    limits = joint_capabilities(machine)
    payload = machine.arm.payload
    reserve, inertia = torque_margin_at_rest(machine, limits, reach * configurations, payload)
    if np.any(reserve < MIN_TORQUE_RESERVE * limits.torque):
        name = list(machine.joints)[int(np.argmin(reserve / limits.torque))]
        reaches = np.floor(100.0 * reach * np.arange(REACH_STEPS - 1, 0, -1) / REACH_STEPS) / 100.0
        reserves = (
            (smaller, torque_margin_at_rest(machine, limits, smaller * configurations, payload)[0])
            for smaller in reaches[reaches >= MIN_REACH]
        )
        possible = next(
            (value for value, reserve in reserves if np.all(reserve >= MIN_TORQUE_RESERVE * limits.torque)), None
        )
        advice = "" if possible is None else f"give {possible:g}, or "
        problem = f"joint {name!r} can't move a payload of {payload:g} kg against gravity at a reach of {reach:g}"
        raise InputError(problem, where="reach", right=f"{advice}give the arm a smaller payload or more pressure")
    return np.asarray(ACCELERATION_FRACTION * simultaneous_accelerations(inertia, reserve))


def _limit_motion(demand: Array, speed: float, acceleration: Array, cycle: float) -> Array:
    """Return the demand (cycles, joints), rad, within limits of speed (rad/s) and acceleration, not overshooting.

    The acceleration, rad/s2, is (joints,); `cycle` is the time from row to row, s.
    """
    limited, increment = demand.copy(), np.zeros(demand.shape[1])  # increment of a cycle
    change = acceleration * cycle**2
    for k in range(1, len(demand)):
        remaining = demand[k] - limited[k - 1]
        # Increments of so many cycles, each smaller by `change` than the one before, end at the demand.
        cycles = np.maximum(np.ceil(0.5 * np.sqrt(8.0 * np.abs(remaining) / change + 1.0) - 0.5), 1.0)
        max_increment = np.minimum(np.abs(remaining) / cycles + 0.5 * (cycles - 1.0) * change, speed * cycle)
        increment = np.clip(np.copysign(max_increment, remaining), increment - change, increment + change)
        limited[k] = limited[k - 1] + increment
    return limited


def _sequence_levels(duration: float, cycle: float, *seeds: int) -> Array:
    """Return all `SEQUENCE_PARTS` in turn, random by `seeds`, in fractions of the reach, (cycles,)."""
    random = np.random.default_rng(seeds)
    parts = []
    for share, part in SEQUENCE_PARTS:
        count = round(share * duration / cycle)
        parts.append(part(np.asarray(cycle * np.arange(count), dtype=np.float64), cycle * count, random))
    return np.concatenate(parts)
