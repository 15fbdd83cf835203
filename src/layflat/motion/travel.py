"""Demands with limited speed, acceleration and jerk, one row a control cycle: from rest to rest, or between motions.

Time-optimal within the limits, all axes ending together. Source: berscheid2021, the library ruckig.
"""

from dataclasses import dataclass
from math import inf, sqrt
from typing import Any

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.errors import InputError, LayflatError
from layflat.machine import Machine
from layflat.motion.kinematics import tip_position
from layflat.motion.limits import MotionLimits, arm_limits
from layflat.motion.trajectory import States, Trajectory, at_rest

LEAD = 0.2  # with which the paper's controllers follow best, s (docs/cell-plan.md)
POINTS = 400  # at which the tip's motion along a path is looked at
# Of the speed, acceleration and jerk that hoses and valves can do: the rest is left to controllers, losses and swing.
# With more, moves settle hardly sooner, and swing further (docs/cell-plan.md).
SHARES = 0.3, 0.6, 0.6


@dataclass(frozen=True)
class Travel(Trajectory):
    """A motion between two postures; from rest to rest it is straight in joint space."""

    start: Array
    end: Array
    limits: MotionLimits  # that it keeps
    _trajectory: Any

    def _states(self, times: Array) -> States:
        return States(*(np.array(of) for of in zip(*map(self._trajectory.at_time, times.tolist()), strict=True)))

    def demand(self, cycle: float, *, lead: float = 0.0) -> Array:
        """Return one row a control cycle (s), (cycles, axes), from the start to the end.

        The demand runs ahead by `lead` (s) at the motion's speed, but not past its end: a controller of the error lags
        behind what moves.
        """
        angles, velocities, _ = self.rows(cycle)
        ahead = angles + lead * velocities
        return np.clip(ahead, np.minimum(self.start, self.end), np.maximum(self.start, self.end))


def travel(start: Array, end: Array, limits: MotionLimits) -> Travel:
    """Plan the quickest way from rest to rest between two positions (axes,), rad or m; raise as `transfer`."""
    return transfer(at_rest(start), at_rest(end), limits)


def transfer(start: States, end: States, limits: MotionLimits, *, duration: float = 0.0) -> Travel:
    """Plan the quickest way from one motion into another, (axes,) each; it takes at least `duration`, s.

    Raises:
        InputError: ruckig is not installed, or a number is not finite.
        LayflatError: the motion at the end is beyond the limits.
    """
    otg, axes = extras.module("motion", "ruckig"), len(start.angles)
    if not (np.isfinite(start).all() and np.isfinite(end).all()):
        raise InputError("a position is not finite", where="travel", right="give numbers only")
    wanted = otg.InputParameter(axes)
    wanted.current_position, wanted.current_velocity, wanted.current_acceleration = (of.tolist() for of in start)
    wanted.target_position, wanted.target_velocity, wanted.target_acceleration = (of.tolist() for of in end)
    wanted.max_velocity, wanted.max_acceleration = list(limits.speed), list(limits.acceleration)
    wanted.max_jerk = list(limits.jerk)
    if duration > 0.0:
        wanted.minimum_duration = duration
    # Phases that agree keep to the straight line between both postures, where there is one.
    wanted.synchronization = otg.Synchronization.Phase
    trajectory = otg.Trajectory(axes)
    result = otg.Ruckig(axes).calculate(wanted, trajectory)
    if result not in {otg.Result.Working, otg.Result.Finished}:
        raise LayflatError(f"no motion from {start.angles.tolist()} to {end.angles.tolist()} was found: {result}")
    return Travel(float(trajectory.duration), start.angles.copy(), end.angles.copy(), limits, trajectory)


def move_arm(
    machine: Machine, start: Array | States, end: Array, *, payload: float | None = None,
    tip_acceleration: float = inf, tip_speed: float = inf, shares: tuple[float, float, float] = SHARES,
) -> Travel:  # fmt: skip
    """Plan a move of an arm's joints to angles (joints,), rad, within shares of what it can do.

    It starts at rest at angles, or in motion. The payload (kg) is by default the machine's. The planned motion of the
    tip exceeds neither the speed (m/s) nor the acceleration (m/s2) that are given for it, as far as it does not begin
    with more: soft fruit bruises. Raise as `travel` and `arm_limits`.
    """
    begin, rest = start if isinstance(start, States) else at_rest(start), at_rest(end)
    path = transfer(begin, rest, arm_limits(machine, begin.angles, end, payload=payload).shares(*shares))
    if tip_acceleration == tip_speed == inf:
        return path
    speed, acceleration = tip_peaks(machine, path)
    # From rest, the same way in k times the time has 1/k of the speed and 1/k^2 of the acceleration.
    factor = max(speed / tip_speed, sqrt(acceleration / tip_acceleration))
    return path if factor <= 1.0 else transfer(begin, rest, path.limits.slower(factor))


def tip_peaks(machine: Machine, path: Travel) -> tuple[float, float]:
    """Return the greatest speed (m/s) and acceleration (m/s2) of the tip along a planned motion of the arm."""
    if path.duration == 0.0:
        return 0.0, 0.0
    tips, step = tip_position(machine, path.at(np.linspace(0.0, path.duration, POINTS + 1))), path.duration / POINTS
    first, second = np.diff(tips, axis=0) / step, np.diff(tips, n=2, axis=0) / step**2
    return float(np.linalg.norm(first, axis=1).max()), float(np.linalg.norm(second, axis=1).max())
