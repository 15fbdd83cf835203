"""Iterative learning of a move in simulation, from the sensors' readings alone, as on a rig."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.learning import LearntCorrections, begin_learning, path_error
from layflat.motion.trajectory import States, Trajectory
from layflat.sim.run import rollout

__all__ = ["learnt_error_ratio", "simulated_repeats"]

SEED_SPACING = 1000  # between the noise seeds of two sequences of repeats


class SimulatedRepeat(NamedTuple):
    """Repeat of a move in simulation."""

    learnt: LearntCorrections  # state of the learning after the repeat
    angles: Array  # true angles at the control cycles of the repeat's demand, (cycles, joints), rad


def simulated_repeats(
    learnt: LearntCorrections, repeats: int, *, plant: Machine | None = None, seed: int = 0
) -> Iterator[SimulatedRepeat]:
    """Yield repeats of a move, each with other noise and with the demand learnt so far.

    Args:
        learnt: state of the learning at the start.
        repeats: number of repeats.
        plant: the machine that moves, where it differs from the model that the controller and the learning use.
        seed: seed of the noise, to which the number of repeats in the history of `learnt` is added.

    Raises:
        DivergedError: the plant diverged.
    """
    for _ in range(repeats):
        angles, measured = _simulate_demand(learnt, learnt.demand(), plant, seed + len(learnt.history))
        learnt = learnt.learn_from(measured)
        yield SimulatedRepeat(learnt, angles)


def learnt_error_ratio(
    machine: Machine, plant: Machine, motion: Trajectory | States, repeats: int = 5, seeds: Sequence[int] = (0,)
) -> float:
    """Return the rms path error of the true tip after learning, over that of the first run.

    After the first run and the repeats, the best demand by the sensors is simulated once more, with other noise.

    Args:
        machine: the model that the controller and the learning use.
        plant: the machine that moves; None for `machine` itself.
        motion: motion to learn.
        repeats: number of repeats after the first run.
        seeds: seeds of sequences of repeats, over which the errors' mean squares are taken.

    Raises:
        DivergedError: the plant diverged.
    """
    first, last = [], []
    for seed in seeds:
        learnt = begin_learning(machine, motion.rows(machine.cycle) if isinstance(motion, Trajectory) else motion)
        for number, repeat in enumerate(simulated_repeats(learnt, repeats + 1, plant=plant, seed=SEED_SPACING * seed)):
            learnt = repeat.learnt
            if number == 0:
                first.append(true_error(learnt, repeat.angles))
        angles, _ = _simulate_demand(learnt, learnt.best_demand(), plant, SEED_SPACING * seed + repeats + 1)
        last.append(true_error(learnt, angles))
    return float(np.sqrt(np.mean(np.square(last)) / np.mean(np.square(first))))


def true_error(learnt: LearntCorrections, angles: Array) -> float:
    """Return the rms distance (m) of the tip from its path, by angles (rad) at the control cycles of a demand."""
    return path_error(learnt.machine, learnt.motion, angles[learnt.lead_in_cycles :])[0]


def _simulate_demand(
    learnt: LearntCorrections, demand: States, plant: Machine | None, seed: int
) -> tuple[Array, Array]:
    """Return true and measured angles at the control cycles of a demand, (cycles, joints) each, rad."""
    count = len(demand.angles)
    run = rollout(
        plant or learnt.machine,
        demand.angles,
        demand_velocity=demand.velocities,
        demand_acceleration=demand.accelerations,
        duration=count * learnt.motion.cycle,
        controller=learnt.machine,
        seed=seed,
    )
    return run["angle"].to_numpy()[:count], run["measured_angle"].to_numpy()[:count]
