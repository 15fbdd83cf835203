"""A bench sequence from which a machine can be identified: what to ask of its controller while the log is taken.

Steps fill and vent with the valve wide open; chirps show inertia, lag and delay; slow ramps both ways show friction and
losses; small moves show what lies about the valve's centre; pauses show leakage and heat. The first two thirds hold all
of it, to be fitted; the last third holds it again in other sizes, for validation.

All joints move at the same time, so that an arm shows how they are coupled. Demands are no faster than all of them can
be at once in the worst posture that the sequence comes to, with their payload, against gravity.
"""

from collections.abc import Callable

import numpy as np
from scipy.signal import chirp

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.dynamics import room_at_rest
from layflat.motion.limits import abilities, together

REACH, NARROW = 0.3, 0.02  # largest angle from the middle, as a share of the working stroke: usual, and least
SPEED = 5.0  # greatest rate of the demand, rad/s: steps are ramps that a valve wide open follows
SHARE = 0.5  # of the accelerations that all joints have at once
RISE = 0.1  # least time in which a demand comes to its greatest rate, s: at 0.05 s light joints are thrown about
LEAST = 0.2  # share of its torque that is left to move a joint where gravity, friction and losses are the greatest
LOOKED_AT = 0.2  # time from one posture that is looked at to the next, s
SMALLER = 10  # shares of the reach that are tried where it is too large
WHOLE, AGAIN = 28.0, 14.0  # length of what is fitted, and of what is for validation, s


def _steps(t: Array, duration: float, random: np.random.Generator) -> Array:
    """Steps of all sizes, with pauses."""
    count = max(3, round(duration / 0.9))
    levels = np.append(random.permutation(np.linspace(-1.0, 1.0, count - 1)), 0.0)
    return np.asarray(levels[np.minimum((count * t / duration).astype(int), count - 1)])


def _chirp(t: Array, duration: float, random: np.random.Generator) -> Array:
    """A swept sine, 0.3 to 3 Hz."""
    swept = chirp(t, 0.3, duration, 3.0, method="logarithmic", phi=-90)
    return np.asarray(0.3 * random.uniform(0.8, 1.2) * swept)


def _ramps(t: Array, duration: float, random: np.random.Generator) -> Array:
    """Slow sweeps over most of the reach and over half of it, both ways."""
    corners = np.array([0.0, 0.9, -0.9, 0.45, -0.45, 0.0]) * random.choice([-1.0, 1.0])
    ways = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)))])
    return np.asarray(np.interp(t / duration, ways / ways[-1], corners))


def _small(t: Array, duration: float, random: np.random.Generator) -> Array:
    """Moves of a few degrees and less, with pauses."""
    levels = np.array([0.1, -0.1, 0.04, -0.04, 0.0]) * random.choice([-1.0, 1.0])
    return np.asarray(levels[np.minimum((len(levels) * t / duration).astype(int), len(levels) - 1)])


PARTS: tuple[tuple[float, Callable[..., Array]], ...] = (
    (0.05, lambda t, *_: np.zeros_like(t)), (0.26, _steps), (0.25, _chirp), (0.3, _ramps), (0.14, _small),
)  # fmt: skip
"""Shares of the whole time, and what gives angles in shares of the reach from times (s), duration and a generator."""


def sequence(machine: Machine, *, reach: float = REACH, speed: float = SPEED, seed: int = 0) -> tuple[Array, Array]:
    """Times (s, (cycles,)) and demands (rad, (cycles, joints)) for a machine's controller.

    Args:
        machine: what is excited; raise InputError if it has no controller that follows demands, or can't hold itself
            against gravity.
        reach: largest angle from the middle, as a share of the working stroke.
        speed: greatest rate of the demand, rad/s.
        seed: of sizes and order, which differ from joint to joint.
    """
    lacking = machine.control_law.gains is not None and any(joint.gains is None for joint in machine.joints.values())
    if machine.controller is None or lacking:
        where = f"{machine.origin}: controller"
        raise InputError("has no gains to follow a sequence with", where=where, right="tune it first: `layflat tune`")
    if not NARROW <= reach <= 0.45:
        raise InputError(f"{reach:g} is out of range", where="reach", right="give a share of the stroke, 0.02 to 0.45")
    if not speed > 0.0:
        raise InputError(f"{speed:g} rad/s is out of range", where="speed", right='give more than zero: "300 deg/s"')
    cycle = machine.controller.cycle
    strokes = np.array([joint.stops.working_stroke for joint in machine.joints.values()])
    joints = range(len(strokes))
    played = [np.concatenate([_played(WHOLE, cycle, seed, j), _played(AGAIN, cycle, seed, j, 1)]) for j in joints]
    wanted = strokes * np.stack(played, axis=1)
    acceleration = np.minimum(_accelerations(machine, wanted[:: round(LOOKED_AT / cycle)], reach), speed / RISE)
    demand = _followed(reach * wanted, speed, acceleration, cycle)
    return np.asarray(cycle * np.arange(len(demand)), dtype=np.float64), demand


def _accelerations(machine: Machine, postures: Array, reach: float) -> Array:
    """Accelerations for all joints at once in the worst of the postures (rad, per reach), (joints,), rad/s2.

    Raises:
        InputError: a joint can't hold itself against gravity in one of them.
    """
    able = abilities(machine)
    payload = machine.arm.payload
    room, inertia = room_at_rest(machine, able, reach * postures, payload)
    if np.any(room < LEAST * able.torque):
        name = list(machine.joints)[int(np.argmin(room / able.torque))]
        tried = np.floor(100.0 * reach * np.arange(SMALLER - 1, 0, -1) / SMALLER) / 100.0
        rooms = ((one, room_at_rest(machine, able, one * postures, payload)[0]) for one in tried[tried >= NARROW])
        carried = next((one for one, left in rooms if np.all(left >= LEAST * able.torque)), None)
        smaller = "" if carried is None else f"give {carried:g}, or "
        what = f"joint {name!r} can't move {payload:g} kg against gravity where {reach:g} leads it"
        raise InputError(what, where="reach", right=f"{smaller}give the arm a smaller payload or more pressure")
    return np.asarray(SHARE * together(inertia, room))


def _followed(wanted: Array, speed: float, acceleration: Array, cycle: float) -> Array:
    """What is wanted (cycles, joints), as closely as speed and accelerations allow without passing it by."""
    followed, way = wanted.copy(), np.zeros(wanted.shape[1])  # the way of a cycle
    bend = acceleration * cycle**2
    for k in range(1, len(wanted)):
        left = wanted[k] - followed[k - 1]
        # Ways of so many cycles, each shorter by `bend` than the one before, end there.
        cycles = np.maximum(np.ceil(0.5 * np.sqrt(8.0 * np.abs(left) / bend + 1.0) - 0.5), 1.0)
        most = np.minimum(np.abs(left) / cycles + 0.5 * (cycles - 1.0) * bend, speed * cycle)
        way = np.clip(np.copysign(most, left), way - bend, way + bend)
        followed[k] = followed[k - 1] + way
    return followed


def _played(duration: float, cycle: float, *seeds: int) -> Array:
    """All parts, one after the other, in shares of the reach."""
    random = np.random.default_rng(seeds)
    parts = []
    for share, part in PARTS:
        count = round(share * duration / cycle)
        parts.append(part(np.asarray(cycle * np.arange(count), dtype=np.float64), cycle * count, random))
    return np.concatenate(parts)
