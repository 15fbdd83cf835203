"""Point-to-point motions with limited speed, acceleration and jerk, from rest or from motion, and their demands.

Time-optimal within the limits, with all axes ending together. Source: berscheid2021, the library ruckig. The demands
depend on the control law: with their rates, or angles alone that lead the motion.
"""

from dataclasses import dataclass
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.errors import InputError, LayflatError
from layflat.machine import Machine
from layflat.motion.kinematics import tip_position
from layflat.motion.limits import FEEDBACK_RESERVE, MotionLimits, arm_limits
from layflat.motion.trajectory import States, Trajectory, rest_states

DEMAND_LEAD = 0.2  # with which the paper's controllers follow best, s (docs/cell-plan.md)
TIP_SAMPLES = 400  # intervals in which the tip's motion is evaluated
# Fractions of the speed, acceleration and jerk that hoses and valves can do: the rest is left to feedback, losses and
# oscillation. With more, moves settle hardly sooner, and oscillate more (docs/cell-plan.md).
LIMIT_FRACTIONS = 0.3, 0.6, 0.6


@dataclass(frozen=True)
class PlannedMove(Trajectory):
    """Motion between two configurations; from rest to rest it is straight in joint space."""

    start: Array
    end: Array
    limits: MotionLimits  # of the motion
    _trajectory: Any

    def _states(self, times: Array) -> States:
        return States(*(np.array(rows) for rows in zip(*map(self._trajectory.at_time, times.tolist()), strict=True)))

    def demand(self, cycle: float, *, lead: float = 0.0) -> Array:
        """Return demanded angles at every control cycle (s), (cycles, axes), from the start to the end.

        The demand leads the motion by `lead` (s) times its velocity, but not beyond its end, as a controller of the
        error alone lags behind a motion.
        """
        angles, velocities, _ = self.rows(cycle)
        ahead = angles + lead * velocities
        return np.clip(ahead, np.minimum(self.start, self.end), np.maximum(self.start, self.end))


def plan_travel(start: Array, end: Array, limits: MotionLimits) -> PlannedMove:
    """Plan the quickest straight motion from rest to rest between two positions, all axes ending together.

    Args:
        start: position, (axes,), rad or m.
        end: position, likewise.
        limits: limits of the axes' speed, acceleration and jerk; positions are not limited.

    Raises:
        InputError: ruckig is not installed, or a number is not finite.
        LayflatError: no motion was found.
    """
    return plan_transfer(rest_states(start), rest_states(end), limits)


def plan_transfer(start: States, end: States, limits: MotionLimits, *, duration: float = 0.0) -> PlannedMove:
    """Plan the quickest motion from one state of motion to another, all axes ending together.

    Args:
        start: state, (axes,) each.
        end: state, likewise.
        limits: limits of the axes.
        duration: minimum, s.

    Raises:
        InputError: ruckig is not installed, or a number is not finite.
        LayflatError: no motion was found, as where the motion at the end is beyond the limits.
    """
    otg, axes = extras.import_extra("motion", "ruckig"), len(start.angles)
    if not (np.isfinite(start).all() and np.isfinite(end).all()):
        raise InputError("a position or a rate is not finite", where="travel", right="give finite numbers")
    request = otg.InputParameter(axes)
    request.current_position, request.current_velocity, request.current_acceleration = (row.tolist() for row in start)
    request.target_position, request.target_velocity, request.target_acceleration = (row.tolist() for row in end)
    request.max_velocity, request.max_acceleration = list(limits.speed), list(limits.acceleration)
    request.max_jerk = list(limits.jerk)
    if duration > 0.0:
        request.minimum_duration = duration
    # Synchronized phases keep to the straight line between both configurations, where there is one.
    request.synchronization = otg.Synchronization.Phase
    trajectory = otg.Trajectory(axes)
    result = otg.Ruckig(axes).calculate(request, trajectory)
    if result not in {otg.Result.Working, otg.Result.Finished}:
        raise LayflatError(f"no motion from {start.angles.tolist()} to {end.angles.tolist()} was found: {result}")
    return PlannedMove(float(trajectory.duration), start.angles.copy(), end.angles.copy(), limits, trajectory)


def plan_move(
    machine: Machine, start: Array | States, end: Array, *, payload: float | None = None,
    tip_acceleration: float = inf, tip_speed: float = inf, fractions: tuple[float, float, float] = LIMIT_FRACTIONS,
) -> PlannedMove:  # fmt: skip
    """Plan a move of an arm's joints to rest at a configuration.

    Args:
        machine: machine whose arm moves.
        start: angles of rest (joints,), rad, or a state of motion.
        end: angles (joints,), rad.
        payload: kg; default: the machine's.
        tip_acceleration: greatest of the tip, m/s2.
        tip_speed: greatest of the tip, m/s; a start with more can exceed it.
        fractions: fractions of the greatest speed, acceleration and jerk of the joints.

    Raises:
        InputError: ruckig is not installed, or a number is not finite.
        MachineError: the machine has no valves, or can't hold itself.
        LayflatError: no motion was found.
    """
    begin, rest = start if isinstance(start, States) else rest_states(start), rest_states(end)
    path = plan_transfer(begin, rest, arm_limits(machine, begin.angles, end, payload=payload).scaled(*fractions))
    if tip_acceleration == tip_speed == inf:
        return path
    speed, acceleration = tip_peaks(machine, path)
    # From rest, the same path in k times the duration has 1/k of the speed and 1/k^2 of the acceleration.
    factor = max(speed / tip_speed, sqrt(acceleration / tip_acceleration))
    return path if factor <= 1.0 else plan_transfer(begin, rest, path.limits.slowed(factor))


def tip_peaks(machine: Machine, path: PlannedMove) -> tuple[float, float]:
    """Return the greatest speed (m/s) and acceleration (m/s2) of the tip along a motion, by `TIP_SAMPLES` differences.

    Both are 0 for a motion without duration.
    """
    if path.duration == 0.0:
        return 0.0, 0.0
    tips, step = (
        tip_position(machine, path.angles_at(np.linspace(0.0, path.duration, TIP_SAMPLES + 1))),
        path.duration / TIP_SAMPLES,
    )
    first, second = np.diff(tips, axis=0) / step, np.diff(tips, n=2, axis=0) / step**2
    return float(np.linalg.norm(first, axis=1).max()), float(np.linalg.norm(second, axis=1).max())


class DemandStyle(NamedTuple):
    """Form of the demands of motions: with rates, or angles that lead the motion."""

    lead_time: float  # of the demand before the motion, s; 0 for demands with rates
    limit_fractions: tuple[float, float, float]  # of speed, acceleration and jerk with which motions are planned

    def demands(self, move: PlannedMove, cycle: float) -> States:
        """Return the demands of a move at every control cycle (s); angles that lead have zero rates."""
        return move.rows(cycle) if self.lead_time == 0.0 else rest_states(move.demand(cycle, lead=self.lead_time))

    def demand(self, motion: States) -> States:
        """Return the demand for a state of a continuing motion."""
        return motion if self.lead_time == 0.0 else rest_states(motion.angles + self.lead_time * motion.velocities)


ANGLE_DEMANDS, RATE_DEMANDS = DemandStyle(DEMAND_LEAD, LIMIT_FRACTIONS), DemandStyle(0.0, (1.0 - FEEDBACK_RESERVE,) * 3)


def demand_style(machine: Machine) -> DemandStyle:
    """Return the form of demands that the machine's control law follows best."""
    return RATE_DEMANDS if machine.control_law.plans else ANGLE_DEMANDS
