"""How stiff an arm is that is asked for a stiffness: pushed at rest, over its stroke, at three levels."""

from dataclasses import dataclass

import numpy as np

from layflat.arrays import Array
from layflat.control.tracking.stiffness import TURN, stiffness
from layflat.description.change import changed_all, value_at
from layflat.machine import Machine, load, parameters
from layflat.physics.joint import FILLED
from layflat.sim import rollout

ADJUSTABLE = "paper-arm-adjustable"  # built-in machine whose callipers, regulators and supply others are given
LEVELS = (0.24, 0.48, 0.96)  # shares of what the joints have at full supply in the middle of their strokes
POSTURES = (0.0, 1 / 3, -2 / 3, 3 / 4)  # of the first joint, as shares of half the stroke; the next are mirrored
ADJUSTS, FILLS = 6.0, 50.0  # time for each level: so many seconds, and times in which an open valve fills hoses
PUSHED = 2.0  # of each of three pushes, and of a rest after them, s
CALM = 0.8  # share of a push in which it comes up, so slowly that the joint does not swing


@dataclass(frozen=True)
class Stiffness:
    """What was found at each level, in each posture, of each joint, (levels, postures, joints)."""

    asked: Array  # N m/rad
    measured: Array  # by pushes to and fro, N m/rad
    moved: Array  # away from the goal while the stiffness was changed, rad

    @property
    def spread(self) -> float:
        """Greatest deviation over the stroke from the mean of a level and joint, as a share."""
        mean = self.measured.mean(axis=1, keepdims=True)
        return float(np.abs(self.measured / mean - 1.0).max())

    @property
    def ratios(self) -> Array:
        """Return each level over that below it, (levels - 1, joints)."""
        mean = self.measured.mean(axis=1)
        found: Array = mean[1:] / mean[:-1]
        return found


def adjustable(machine: Machine) -> Machine:
    """Return the machine with callipers, regulators and the supply of the built-in one that has them."""
    model = load(ADJUSTABLE)
    part = next(iter(model.joint.values()))
    given: dict[str, object] = {"supply.pressure_gauge": model.supply.pressure_gauge}
    for name, joint in machine.joints.items():
        given |= {f"joint.{name}.brake.calliper": joint.brake.calliper or part.brake.calliper}
        given |= {f"joint.{name}.regulator": joint.regulator or part.regulator}
    return changed_all(machine, given)


def stiffnesses(machine: Machine, seeds: int) -> Stiffness:
    """Return what pushes find of a machine with regulators, as means over so many noises."""
    top = _greatest(machine)
    asked = np.array([share * top for share in LEVELS])
    found = [[_pushed(machine, asked, share, seed) for share in POSTURES] for seed in range(seeds)]
    measured, moved = (np.array([[run[i] for run in row] for row in found]) for i in range(2))
    return Stiffness(asked, measured.mean(axis=0).swapaxes(0, 1), moved.max(axis=0).swapaxes(0, 1))


def _greatest(machine: Machine) -> Array:
    p = FILLED * machine.supply.pressure
    return np.array(
        [stiffness(joint, 0.0, p, p, machine.supply.ambient_pressure) for joint in parameters.joints(machine)]
    )


def _adjusts(machine: Machine) -> float:
    actuators = parameters.control(machine).actuators
    fills = max(actuator.torque / actuator.rate for actuator in actuators)
    return float(machine.cycle * np.ceil((ADJUSTS + FILLS * fills) / machine.cycle))


def _pushed(machine: Machine, asked: Array, share: float, seed: int) -> tuple[Array, Array]:
    """Stiffnesses, (levels, joints), and by how much the joints moved before they were pushed, likewise."""
    results = [_one(machine, asked, share, j, seed) for j in range(asked.shape[1])]
    measured = np.stack([found[:, j] for j, (found, _) in enumerate(results)], axis=1)
    return measured, np.max([moved for _, moved in results], axis=0)


def _one(machine: Machine, asked: Array, share: float, pushed: int, seed: int) -> tuple[Array, Array]:
    levels, joints = asked.shape
    T, adjusts = machine.cycle, _adjusts(machine)
    lasts = adjusts + 4 * PUSHED
    t = T * np.arange(round(levels * lasts / T))
    level, since = np.minimum((t / lasts + 1e-9).astype(int), levels - 1), np.mod(t + 1e-9, lasts) - adjusts
    side = _sides(since / PUSHED)
    load_torque = np.zeros((len(t), joints))
    load_torque[:, pushed] = side * TURN * asked[level, pushed]
    half = np.array([value_at(machine, f"joint.{name}.stops.working_stroke") for name in machine.joints]) / 2
    goal = share * half * (-1.0) ** np.arange(joints)
    demand = [(0.0, (0.5 * goal).tolist()), (0.1, goal.tolist())]
    run = rollout(machine, demand, demand_stiffness=asked[level], load=load_torque, duration=len(t) * T, seed=seed)
    angles = run["angle"].to_numpy()[:-1]
    measured, moved = np.zeros((levels, joints)), np.zeros((levels, joints))
    for i in range(levels):
        at = [
            angles[(level == i) & (since >= (w + CALM) * PUSHED) & (since < (w + 1) * PUSHED), pushed].mean()
            for w in range(3)
        ]
        measured[i, pushed] = 2.0 * TURN * asked[i, pushed] / ((at[0] + at[2]) / 2 - at[1])
        settled = np.abs(angles[(level == i) & (since >= 1.0 - adjusts) & (since < 0.0)] - goal)
        moved[i] = (settled - settled[0]).max(axis=0)
    return measured, moved


def _sides(time: Array) -> Array:
    """Return to which side joints are pushed, -1..1: three times to and fro, smoothly, once a unit of time."""
    sides = np.array([0.0, 1.0, -1.0, 1.0, 0.0])  # before, and in each push and after it
    push = np.clip(np.floor(time).astype(int) + 1, 0, len(sides) - 1)
    share = 0.5 - 0.5 * np.cos(np.pi * np.clip((time - push + 1) / CALM, 0.0, 1.0))
    before = sides[np.maximum(push - 1, 0)]
    return np.asarray(before + share * (sides[push] - before))
