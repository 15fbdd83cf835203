"""Moves by which controllers are compared: steps from configurations all over the strokes, and belts to follow.

Steps are of one and of all joints; belts run to and fro.
"""

from dataclasses import dataclass
from itertools import product
from math import radians

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.belt import follow_belt
from layflat.motion.kinematics import tip_position
from layflat.motion.path import half_strokes
from layflat.motion.planar import PlanarReach
from layflat.motion.scenario import Scenario
from layflat.sim import rollout

CONFIGURATION_COUNT = 16  # from which moves begin
STEP_ANGLE = radians(40.0)
STROKE_MARGIN = radians(5.0)  # to the ends of the strokes
FIRST_MOVE_TIME, MOVE_INTERVAL = 0.5, 1.5  # of the first move, and from move to move, s


def move_sequences(machine: Machine, count: int) -> list[Scenario]:
    """Return a scenario of `count` consecutive moves from each of `CONFIGURATION_COUNT` initial configurations."""
    rng = np.random.default_rng(1)
    return [_moves_scenario(_draw_angles(machine, count, number, rng)) for number in range(CONFIGURATION_COUNT)]


def first_moves(machine: Machine) -> list[tuple[Array, Array]]:
    """Return the moves of `move_sequences` with one move each: angles (joints,) before and after it, rad."""
    rng = np.random.default_rng(1)
    return [
        (rows[0], rows[1]) for rows in (_draw_angles(machine, 1, number, rng) for number in range(CONFIGURATION_COUNT))
    ]


def _draw_angles(machine: Machine, count: int, number: int, rng: np.random.Generator) -> Array:
    """Return the angles at rest before, between and after the moves, (count + 1, joints), rad."""
    limit = half_strokes(machine) - STROKE_MARGIN
    directions = [direction for direction in product((1.0, 0.0, -1.0), repeat=len(limit)) if _is_step(direction)]
    rows = []
    angles = rng.uniform(-limit, limit)
    for move in range(count):
        step = STEP_ANGLE * rng.choice([-1.0, 1.0]) * np.array(directions[(number + move) % len(directions)])
        if move == 0:
            angles = np.clip(angles, np.maximum(-limit, -limit - step), np.minimum(limit, limit - step))
            rows.append(angles)
        angles = angles + np.where(np.abs(angles + step) > limit + 1e-9, -step, step)
        rows.append(angles)
    return np.array(rows)


def _is_step(direction: tuple[float, ...]) -> bool:
    """Return whether one joint moves or all do; of two opposite directions, only the first forward one counts."""
    moved = [side for side in direction if side]
    return len(moved) in (1, len(direction)) and moved[0] > 0.0


def _moves_scenario(rows: Array) -> Scenario:
    """Return the scenario of moves to rows of angles (rad) every `MOVE_INTERVAL`; the first row is the start."""
    times = [0.0, *(FIRST_MOVE_TIME + MOVE_INTERVAL * move for move in range(len(rows) - 1))]
    return Scenario(
        demand=list(zip(times, rows.tolist(), strict=True)), duration=FIRST_MOVE_TIME + MOVE_INTERVAL * (len(rows) - 1)
    )


BELT_DISTANCE, BELT_LENGTH = 0.55, 0.36  # of the belt from the arm's base, and of its motion, fractions of the reach
BELT_ACCELERATION = 3.0  # m/s2
BELT_RUN_DURATION, CATCH_TIME = 4.0, 1.0  # of a run, and time from which distances count, s
BELT_DIRECTION = np.pi / 2  # angle of the belt to the base's x axis, rad


@dataclass(frozen=True)
class BeltFollowing:
    """Distances of the tip from a moving belt, m, under a control law at a speed (m/s)."""

    law: str
    speed: float
    distances: Array

    @property
    def rms(self) -> float:
        """Root mean square of the distances, m."""
        return float(np.sqrt(np.mean(self.distances**2)))

    @property
    def max_distance(self) -> float:
        """Greatest distance, m."""
        return float(self.distances.max())


def measure_belt_following(law: str, machine: Machine, speed: float, seeds: int) -> BeltFollowing:
    """Simulate a planar arm of two joints that follows a belt, and return its distances from it.

    They are those of all cycles from `CATCH_TIME` on, seed after seed; a run begins 10 deg off the belt in each joint.

    The demand is angle, velocity and acceleration of its joints; the belt reverses at both ends.

    Args:
        law: label of the control law.
        machine: machine with that law.
        speed: speed of the belt, m/s.
        seeds: number of runs with different noise.
    """
    angles, velocities, accelerations = belt_motion(machine, speed)
    reference, first_cycle = tip_position(machine, angles), round(CATCH_TIME / machine.cycle)
    distances = []
    for seed in range(seeds):
        run = rollout(
            machine, angles, demand_velocity=velocities, demand_acceleration=accelerations,
            duration=len(angles) * machine.cycle, start=_offset_start(angles[0]), seed=seed,
        )  # fmt: skip
        distance = np.linalg.norm(tip_position(machine, run["angle"].to_numpy()[:-1]) - reference, axis=1)
        distances.append(distance[first_cycle:])
    return BeltFollowing(law, speed, np.concatenate(distances))


def belt_motion(machine: Machine, speed: float) -> tuple[Array, Array, Array]:
    """Return angles, velocities and accelerations (cycles, joints) in SI units that keep the tip on the belt."""
    reach, total_length = PlanarReach(machine), sum(joint.planar_link.length for joint in machine.joints.values())
    x, low, length = BELT_DISTANCE * total_length, 0.02 * total_length, BELT_LENGTH * total_length
    start = np.array(reach.configurations(x, low)[0].angles)
    period = length / speed
    reversals = [(k * period, speed if k % 2 == 0 else -speed) for k in range(int(BELT_RUN_DURATION / period))]
    motion = follow_belt(
        machine, start, BELT_DIRECTION, [*reversals, (len(reversals) * period, 0.0)], BELT_ACCELERATION
    )
    angles, velocities, accelerations = motion.rows(machine.cycle)
    return angles, velocities, accelerations


def _offset_start(start: Array) -> list[float]:
    """Return a configuration with every joint 10 deg nearer to mid-stroke, from which the arm catches up, rad."""
    angles: list[float] = (start - np.sign(start) * np.radians(10.0)).tolist()
    return angles
