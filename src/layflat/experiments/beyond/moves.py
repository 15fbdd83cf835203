"""Moves that controllers are compared by: steps of one and of all joints, from postures all over their strokes."""

from itertools import product
from math import radians

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.scenario import Scenario

POSTURES = 16
STEP = radians(40.0)
MARGIN = radians(5.0)  # that is kept to the ends of the strokes
REST, PAUSE = 0.5, 1.5  # before the first move, and from move to move, s


def sequences(machine: Machine, count: int) -> list[Scenario]:
    """Return so many moves after each other from each of `POSTURES` postures."""
    draw = np.random.default_rng(1)
    return [_scenario(_angles(machine, count, posture, draw)) for posture in range(POSTURES)]


def steps(machine: Machine) -> list[tuple[Array, Array]]:
    """Return the first moves of `sequences`: angles (joints,) before and after them, rad."""
    draw = np.random.default_rng(1)
    return [(rows[0], rows[1]) for rows in (_angles(machine, 1, posture, draw) for posture in range(POSTURES))]


def _angles(machine: Machine, count: int, posture: int, draw: np.random.Generator) -> Array:
    """Angles at rest, (count + 1, joints), rad."""
    edge = np.array([joint.stops.working_stroke for joint in machine.joints.values()]) / 2 - MARGIN
    ways = [way for way in product((1.0, 0.0, -1.0), repeat=len(edge)) if _is_step(way)]
    rows = []
    at = draw.uniform(-edge, edge)
    for move in range(count):
        step = STEP * draw.choice([-1.0, 1.0]) * np.array(ways[(posture + move) % len(ways)])
        if move == 0:
            at = np.clip(at, np.maximum(-edge, -edge - step), np.minimum(edge, edge - step))
            rows.append(at)
        at = at + np.where(np.abs(at + step) > edge + 1e-9, -step, step)
        rows.append(at)
    return np.array(rows)


def _is_step(way: tuple[float, ...]) -> bool:
    """True if one joint moves, or all do; of two opposite ones, the one whose first goes forward."""
    moved = [side for side in way if side]
    return len(moved) in (1, len(way)) and moved[0] > 0.0


def _scenario(rows: Array) -> Scenario:
    times = [0.0, *(REST + PAUSE * move for move in range(len(rows) - 1))]
    return Scenario(demand=list(zip(times, rows.tolist(), strict=True)), duration=REST + PAUSE * (len(rows) - 1))
