"""Motions along a path, from rest to rest, with limited speed, acceleration and jerk.

Each limit is constant along the path, at the least value that any of its points allows; symbols as in dynamics.py.
"""

from math import inf

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.dynamics import path_torques, rigid_torques
from layflat.motion.kinematics import tip_motion
from layflat.motion.limits import (
    FEEDBACK_RESERVE,
    JointCapabilities,
    MotionLimits,
    TipLimits,
    check_holding_torque,
    joint_capabilities,
)
from layflat.motion.path import SAME_POINT_DISTANCE, JointPath
from layflat.motion.trajectory import PathMotion, RestMotion, Trajectory
from layflat.motion.travel import plan_travel

PATH_SAMPLES = 201  # points of a path, and instants of a motion, at which limits are evaluated


def plan_jerk_limited(
    machine: Machine, path: JointPath, *, payload: float | None = None, tip: TipLimits | None = None,
    reserve: float = FEEDBACK_RESERVE, capabilities: JointCapabilities | None = None,
) -> Trajectory:  # fmt: skip
    """Return a motion along a path with limited speed, acceleration and jerk, from rest to rest.

    Mostly slower than `plan_time_optimal`. A path without length gives a `RestMotion` of 0 s.

    Args:
        machine: machine whose arm moves.
        path: path of its joints.
        payload: kg; default: the machine's.
        tip: limits of the tip's motion; default: none.
        reserve: fraction of speeds, torques and torque rates that is left to feedback, 0 to 1.
        capabilities: capabilities of the joints; default: those of hoses and valves.

    Raises:
        MachineError: the arm can't hold itself somewhere on the path, or has no valves.
        InputError: ruckig is not installed.
    """
    if path.length < SAME_POINT_DISTANCE:
        return RestMotion(0.0, path.end)
    mass, tip = machine.arm.payload if payload is None else payload, tip or TipLimits()
    available = (capabilities or joint_capabilities(machine)).with_reserve(reserve)
    s = np.linspace(0.0, path.length, PATH_SAMPLES)
    required = path_torques(machine, path, s, mass)
    upper, lower = available.torque_bounds(required.rate)
    check_holding_torque(machine, required.gravity, upper, lower, mass)
    margin = np.minimum(upper - required.gravity, required.gravity - lower).min(axis=0)
    with np.errstate(divide="ignore"):
        limits = [
            (limit / np.abs(per)).min()
            for limit, per in (
                (available.speed, required.rate),
                (margin, required.mass),
                (available.rate, required.mass),
            )
        ]
    if tip != TipLimits():
        first, _ = tip_motion(machine, *path.evaluate(s))
        limits = np.minimum(limits, np.array(tip) / np.linalg.norm(first, axis=1).max()).tolist()
    path_limits = MotionLimits(*((limit,) for limit in limits))
    motion = _time_path(path, path_limits)
    # In k times the duration, torques of velocities and accelerations are 1/k^2 as large.
    factor = np.sqrt(_torque_excess(machine, motion, mass, margin, tip.acceleration))
    return motion if factor <= 1.0 else _time_path(path, path_limits.slowed(factor))


def _time_path(path: JointPath, limits: MotionLimits) -> PathMotion:
    """Return the quickest motion along a path within limits of its distance."""
    profile = plan_travel(np.zeros(1), np.array([path.length]), limits)

    def timing(times: Array) -> tuple[Array, Array, Array]:
        s, speed, acceleration = (column[:, 0] for column in profile.states(times))
        return s, speed, acceleration

    return PathMotion(profile.duration, path, timing)


def _torque_excess(machine: Machine, motion: PathMotion, payload: float, margin: Array, acceleration: float) -> float:
    """Return the maximum, over joints and instants, of torques beyond the static ones over their margin (N m).

    The ratio of the tip's acceleration to its limit (m/s2) counts likewise.
    """
    states = motion.states(np.linspace(0.0, motion.duration, PATH_SAMPLES))
    still = states._replace(velocities=0.0 * states.velocities, accelerations=0.0 * states.accelerations)
    moving = rigid_torques(machine, states, payload) - rigid_torques(machine, still, payload)
    excess = float((np.abs(moving) / margin).max())
    if acceleration < inf:
        _, second = tip_motion(machine, *states)
        excess = max(excess, float(np.linalg.norm(second, axis=1).max()) / acceleration)
    return excess
