"""Pool of stationary arms with their goals, from which episodes take theirs.

To prepare machines takes milliseconds; to copy the state of one that stands ready takes a fraction of that.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.gym.belt import belt_goals
from layflat.gym.machines import draw_machines, have_equal_geometry
from layflat.gym.tasks import EnvOptions, Task
from layflat.machine import Machine, load
from layflat.motion.path import half_strokes
from layflat.sim.batch import Batch, BatchState
from layflat.sim.batch.actions import find_action

RANGE_FRACTION = 0.8  # of the working stroke, in which starts and goals are
SEEDS_OF_POOL = 4  # independent parts of a pool: machines, starts, goals, payloads


@dataclass(frozen=True)
class Pool:
    """Stationary arms and their goals; a goal that moves has many instants, one that rests has one."""

    described: Machine  # as described
    machine: Machine  # of the structure of all arms
    rest: BatchState
    goals: Array  # angles, (instants, joints, arms), rad
    goal_tips: Array  # positions of the tip there, (instants, 3, arms), m

    @property
    def count(self) -> int:
        """Number of arms."""
        return self.rest.count


def make_batch(described: Machine, machine: Machine, count: int, options: EnvOptions, **arms: Any) -> Batch:
    """Return the batch of an environment.

    Args:
        described: machine whose control law follows demands; it knows no other arm.
        machine: machine of the structure of all arms.
        count: number of arms.
        options: options of the environment.
        arms: further arguments of `Batch`.
    """
    driver = described if find_action(options.action).demands else None
    return Batch(
        machine, count, action=options.action, controller=driver, precision=options.precision,
        threads=options.threads, **arms,
    )  # fmt: skip


def make_pool(task: Task, options: EnvOptions) -> Pool:
    """Return the pool of an environment.

    Args:
        task: what the arms are to do.
        options: checked options.

    Raises:
        InputError: the machine or an option is wrong, or the set of machines does not suit the task.
    """
    described = load(task.machine if options.machine is None else options.machine)
    of_machines, *seeds = np.random.SeedSequence(options.pool_seed).generate_state(SEEDS_OF_POOL).tolist()
    to_start, to_aim, to_load = map(np.random.default_rng, seeds)
    name = task.machines if options.machines is None else options.machines
    group = draw_machines(described, name, options.pool, of_machines)
    vary = dict(group.vary)
    if task.payloads is not None:
        vary["scenario.payload"] = to_load.uniform(*task.payloads, options.pool)
    limits: Array = RANGE_FRACTION * half_strokes(described)
    starts, aims = (draw.uniform(-limits, limits, (options.pool, len(limits))) for draw in (to_start, to_aim))
    if task.goal == "start":
        aims = starts
    with make_batch(described, group.machine, options.pool, options, vary=vary, start=aims) as batch:
        goals, tips = aims.T[None], batch.tip.T[None].copy()
        if task.goal != "start":
            batch.reset(start=starts)
        rest = batch.state()
    if task.goal == "belt":
        if not have_equal_geometry(vary):
            what = f"{name!r} has arms of other geometry, whose tips would not meet one belt"
            raise InputError(what, where="machines", right="use nominal or robust")
        times = options.cycles * described.cycle * np.arange(task.episode_steps + 1, dtype=np.float64)
        goals, tips = belt_goals(described, starts, times, limits, int(seeds[1]))
    number = tips.dtype if options.precision == "double" else np.float32
    return Pool(described, group.machine, rest, goals.astype(number), tips.astype(number))
