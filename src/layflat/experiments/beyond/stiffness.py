"""Measurement of demanded stiffness: an arm is pushed at rest, over its stroke, at three levels."""

from dataclasses import dataclass

import numpy as np

from layflat.arrays import Array
from layflat.control.tracking.auxiliary import STIFFNESS_ROTATION, joint_stiffness
from layflat.description.change import changed_all
from layflat.machine import Machine, load, parameters
from layflat.motion.path import half_strokes
from layflat.physics.joint import REST_PRESSURE_RATIO
from layflat.sim import rollout

ADJUSTABLE_MACHINE = "paper-arm-adjustable"  # built-in machine with callipers, regulators and a higher supply
STIFFNESS_LEVELS = (0.24, 0.48, 0.96)  # fractions of the joints' stiffness at full supply and mid-stroke
POSITION_FRACTIONS = (0.0, 1 / 3, -2 / 3, 3 / 4)  # of the first joint, of half its stroke; the next are mirrored
ADJUSTING_TIME = 6.0  # of each level before its pushes, s, to which is added
FILLING_TIMES = 50.0  # so many times the time in which an open valve fills the hoses
PUSH_DURATION = 2.0  # of each of three pushes, and of a rest after them, s
RAMP_FRACTION = 0.8  # of a push, over which the load rises slowly enough not to excite the joint


@dataclass(frozen=True)
class Stiffness:
    """Stiffness at each level, in each configuration, of each joint, (levels, configurations, joints)."""

    demanded: Array  # N m/rad
    measured: Array  # by pushes to and fro, N m/rad
    moved: Array  # away from the goal while the stiffness was changed, rad

    @property
    def max_deviation(self) -> float:
        """Greatest relative deviation over the stroke from the mean of a level and joint."""
        mean = self.measured.mean(axis=1, keepdims=True)
        return float(np.abs(self.measured / mean - 1.0).max())

    @property
    def ratios(self) -> Array:
        """Measured stiffness of each level over that of the level below, (levels - 1, joints)."""
        mean = self.measured.mean(axis=1)
        quotients: Array = mean[1:] / mean[:-1]
        return quotients


def with_stiffness_actuators(machine: Machine) -> Machine:
    """Return the machine with the supply pressure of `ADJUSTABLE_MACHINE`.

    Joints without a calliper or a regulator get those of its first joint.
    """
    model = load(ADJUSTABLE_MACHINE)
    part = next(iter(model.joint.values()))
    changes: dict[str, object] = {"supply.pressure_gauge": model.supply.pressure_gauge}
    for name, joint in machine.joints.items():
        changes |= {f"joint.{name}.brake.calliper": joint.brake.calliper or part.brake.calliper}
        changes |= {f"joint.{name}.regulator": joint.regulator or part.regulator}
    return changed_all(machine, changes)


def measure_stiffness(machine: Machine, seeds: int) -> Stiffness:
    """Return the stiffness of a machine with regulators as measured by pushes: means over so many noise seeds.

    Displacements are the largest ones over the seeds.
    """
    top = _max_stiffness(machine)
    demanded = np.array([share * top for share in STIFFNESS_LEVELS])
    results = [[_push_joints(machine, demanded, share, seed) for share in POSITION_FRACTIONS] for seed in range(seeds)]
    measured, moved = (np.array([[run[i] for run in row] for row in results]) for i in range(2))
    return Stiffness(demanded, measured.mean(axis=0).swapaxes(0, 1), moved.max(axis=0).swapaxes(0, 1))


def _max_stiffness(machine: Machine) -> Array:
    """Return the stiffness (N m/rad) of each joint in the middle, both hoses at `REST_PRESSURE_RATIO` of supply."""
    p = REST_PRESSURE_RATIO * machine.supply.pressure
    return np.array(
        [joint_stiffness(joint, 0.0, p, p, machine.supply.ambient_pressure) for joint in parameters.joints(machine)]
    )


def _adjusting_time(machine: Machine) -> float:
    """Return the time that a change of stiffness gets, s: whole control cycles."""
    actuators = parameters.control(machine).actuators
    fills = max(actuator.torque / actuator.rate for actuator in actuators)
    return float(machine.cycle * np.ceil((ADJUSTING_TIME + FILLING_TIMES * fills) / machine.cycle))


def _push_joints(machine: Machine, demanded: Array, share: float, seed: int) -> tuple[Array, Array]:
    """Return stiffnesses, N m/rad, and displacements before the pushes, rad, both (levels, joints)."""
    results = [_push_joint(machine, demanded, share, j, seed) for j in range(demanded.shape[1])]
    measured = np.stack([stiffness_of_joint[:, j] for j, (stiffness_of_joint, _) in enumerate(results)], axis=1)
    return measured, np.max([moved for _, moved in results], axis=0)


def _push_joint(machine: Machine, demanded: Array, share: float, joint: int, seed: int) -> tuple[Array, Array]:
    """Push a joint both ways at each demanded stiffness, in a simulation.

    Args:
        machine: machine with its controller.
        demanded: stiffness, (levels, joints), N m/rad.
        share: configuration as a fraction of the half strokes, with alternating sign.
        joint: index of the pushed joint.
        seed: seed of the run's noise.

    Returns:
        Measured stiffness (N m/rad, zero except for the joint) and displacement before pushes (rad); (levels, joints).
    """
    levels, joints = demanded.shape
    T, adjusts = machine.cycle, _adjusting_time(machine)
    level_duration = adjusts + 4 * PUSH_DURATION
    t = T * np.arange(round(levels * level_duration / T))
    level, time_in_level = (
        np.minimum((t / level_duration + 1e-9).astype(int), levels - 1),
        np.mod(t + 1e-9, level_duration) - adjusts,
    )
    side = _push_profile(time_in_level / PUSH_DURATION)
    load_torque = np.zeros((len(t), joints))
    load_torque[:, joint] = side * STIFFNESS_ROTATION * demanded[level, joint]
    half = half_strokes(machine)
    goal = share * half * (-1.0) ** np.arange(joints)
    demand = [(0.0, (0.5 * goal).tolist()), (0.1, goal.tolist())]
    run = rollout(machine, demand, demand_stiffness=demanded[level], load=load_torque, duration=len(t) * T, seed=seed)
    angles = run["angle"].to_numpy()[:-1]
    measured, moved = np.zeros((levels, joints)), np.zeros((levels, joints))
    for i in range(levels):
        angles_pushed = [
            angles[
                (level == i)
                & (time_in_level >= (w + RAMP_FRACTION) * PUSH_DURATION)
                & (time_in_level < (w + 1) * PUSH_DURATION),
                joint,
            ].mean()
            for w in range(3)
        ]
        measured[i, joint] = (
            2.0
            * STIFFNESS_ROTATION
            * demanded[i, joint]
            / ((angles_pushed[0] + angles_pushed[2]) / 2 - angles_pushed[1])
        )
        settled = np.abs(angles[(level == i) & (time_in_level >= 1.0 - adjusts) & (time_in_level < 0.0)] - goal)
        moved[i] = (settled - settled[0]).max(axis=0)
    return measured, moved


def _push_profile(time: Array) -> Array:
    """Return the normalized push, -1..1, over time in units of a push: three pushes of alternating sign, smoothed."""
    sides = np.array([0.0, 1.0, -1.0, 1.0, 0.0])  # before, and in each push and after it
    push = np.clip(np.floor(time).astype(int) + 1, 0, len(sides) - 1)
    share = 0.5 - 0.5 * np.cos(np.pi * np.clip((time - push + 1) / RAMP_FRACTION, 0.0, 1.0))
    before = sides[np.maximum(push - 1, 0)]
    return np.asarray(before + share * (sides[push] - before))
