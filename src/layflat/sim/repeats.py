"""Repeats of a move in simulation, learnt from as a rig would: by what the sensors say."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.learning.learnt import Learnt, begin, path_error
from layflat.motion.trajectory import States, Trajectory
from layflat.sim.run import rollout

APART = 1000  # between the seeds of two sequences of repeats


class Simulated(NamedTuple):
    """A repeat in simulation."""

    learnt: Learnt  # after it
    angles: Array  # true ones at the control cycles of its demand, (cycles, joints), rad


def simulated_repeats(
    learnt: Learnt, repeats: int, *, plant: Machine | None = None, seed: int = 0
) -> Iterator[Simulated]:
    """Repeat a move so often, with other noise each time; yield what was learnt after each.

    `plant`: what moves in place of the machine that its controller believes to drive. Raise DivergedError if it does.
    """
    for _ in range(repeats):
        angles, measured = _performed(learnt, learnt.demand(), plant, seed + len(learnt.history))
        learnt = learnt.after(measured)
        yield Simulated(learnt, angles)


def learnt_error_ratio(
    machine: Machine, plant: Machine, motion: Trajectory | States, repeats: int = 5, seeds: Sequence[int] = (0,)
) -> float:
    """Return the rms error along the path after so many repeats, over that of the first run: both of the true tip.

    After the first run and the repeats, the best demand by the sensors is performed once more, with noise of its own.
    """
    first, last = [], []
    for seed in seeds:
        learnt = begin(machine, motion.rows(machine.cycle) if isinstance(motion, Trajectory) else motion)
        for number, done in enumerate(simulated_repeats(learnt, repeats + 1, plant=plant, seed=APART * seed)):
            learnt = done.learnt
            if number == 0:
                first.append(true_error(learnt, done.angles))
        angles, _ = _performed(learnt, learnt.best_demand(), plant, APART * seed + repeats + 1)
        last.append(true_error(learnt, angles))
    return float(np.sqrt(np.mean(np.square(last)) / np.mean(np.square(first))))


def true_error(learnt: Learnt, angles: Array) -> float:
    """Return the rms distance (m) of the tip from its path, from angles (rad) at the cycles of a demand."""
    return path_error(learnt.machine, learnt.wanted, angles[learnt.lead_in :])[0]


def _performed(learnt: Learnt, demand: States, plant: Machine | None, seed: int) -> tuple[Array, Array]:
    """Return true and measured angles at the control cycles of a demand, (cycles, joints) each."""
    count = len(demand.angles)
    run = rollout(
        plant or learnt.machine,
        demand.angles,
        demand_velocity=demand.velocities,
        demand_acceleration=demand.accelerations,
        duration=count * learnt.wanted.cycle,
        controller=learnt.machine,
        seed=seed,
    )
    return run["angle"].to_numpy()[:count], run["measured_angle"].to_numpy()[:count]
