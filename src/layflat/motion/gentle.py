"""Motions along a path, from rest to rest, with limited speed, acceleration and jerk.

Each limit is the same all along the path, the one that its worst place allows; symbols as in dynamics.py.
"""

from math import inf

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.dynamics import path_torques, rigid_torques
from layflat.motion.kinematics import tip_motion
from layflat.motion.limits import RESERVE, Ability, MotionLimits, TipLimits, abilities, check_holds
from layflat.motion.path import CLOSE, Path
from layflat.motion.trajectory import Along, Rest, Trajectory
from layflat.motion.travel import travel

LOOKS = 201  # points of a path, and instants of a motion, that are looked at


def jerk_limited(
    machine: Machine, path: Path, *, payload: float | None = None, tip: TipLimits | None = None,
    reserve: float = RESERVE, able: Ability | None = None,
) -> Trajectory:  # fmt: skip
    """Return a motion along a path with limited speed, acceleration and jerk, from rest to rest.

    Arguments and errors as of `time_optimal`, whose motions are mostly quicker. Raise InputError if ruckig is
    not installed.
    """
    if path.length < CLOSE:
        return Rest(0.0, path.end)
    mass, tip = machine.arm.payload if payload is None else payload, tip or TipLimits()
    left = (able or abilities(machine)).less(reserve)
    s = np.linspace(0.0, path.length, LOOKS)
    asked = path_torques(machine, path, s, mass)
    most, least = left.room(asked.rate)
    check_holds(machine, asked.gravity, most, least, mass)
    room = np.minimum(most - asked.gravity, asked.gravity - least).min(axis=0)
    with np.errstate(divide="ignore"):
        limits = [
            (of / np.abs(per)).min()
            for of, per in ((left.speed, asked.rate), (room, asked.mass), (left.rate, asked.mass))
        ]
    if tip != TipLimits():
        first, _ = tip_motion(machine, *path.at(s))
        limits = np.minimum(limits, np.array(tip) / np.linalg.norm(first, axis=1).max()).tolist()
    chosen = MotionLimits(*((limit,) for limit in limits))
    motion = _along(path, chosen)
    # In k times the time all that velocities and accelerations ask for is 1/k^2.
    factor = np.sqrt(_excess(machine, motion, mass, room, tip.acceleration))
    return motion if factor <= 1.0 else _along(path, chosen.slower(factor))


def _along(path: Path, limits: MotionLimits) -> Along:
    way = travel(np.zeros(1), np.array([path.length]), limits)

    def timing(times: Array) -> tuple[Array, Array, Array]:
        s, speed, acceleration = (of[:, 0] for of in way.states(times))
        return s, speed, acceleration

    return Along(way.duration, path, timing)


def _excess(machine: Machine, motion: Along, payload: float, room: Array, acceleration: float) -> float:
    """Return the torques that a motion asks for besides gravity's over what there is; of the tip's acceleration too."""
    states = motion.states(np.linspace(0.0, motion.duration, LOOKS))
    still = states._replace(velocities=0.0 * states.velocities, accelerations=0.0 * states.accelerations)
    moving = rigid_torques(machine, states, payload) - rigid_torques(machine, still, payload)
    excess = float((np.abs(moving) / room).max())
    if acceleration < inf:
        _, second = tip_motion(machine, *states)
        excess = max(excess, float(np.linalg.norm(second, axis=1).max()) / acceleration)
    return excess
