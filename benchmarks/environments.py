"""Environments of Gymnasium: the fraction of a batch's speed that is left in the vector environment.

Both move arms of the same machines by the same actions, by turns, so that a busy moment of the computer meets both; the
environment also reads sensors late, rewards, and begins all episodes anew at their ends.
"""

import time
from collections.abc import Callable

import numpy as np

from layflat.gym import ARM_TASKS
from layflat.gym.vector import ArmVectorEnv

EPISODE_STEPS = 100
ARMS_IN_ALL = 9 * 4096  # arms of all turns, an episode of each: few arms take more turns


def _seconds(step: Callable[[], object]) -> float:
    """Return the time of the steps of an episode, s."""
    begin = time.perf_counter()
    for _ in range(EPISODE_STEPS):
        step()
    return time.perf_counter() - begin


def share_of_batch(task: str, count: int, cycles: int = 4, delay: int = 1) -> float:
    """Return arm-cycles a second of the environment by those of its batch alone, median of rounds.

    Args:
        task: name of its task.
        count: number of arms.
        cycles: control cycles of a step of the environment.
        delay: control cycles by which readings are older.
    """
    envs = ArmVectorEnv(task, count, max_episode_steps=EPISODE_STEPS, machines="robust", cycles=cycles, delay=delay)
    envs.reset(seed=1)
    actions = np.random.default_rng(2).uniform(-1.0, 1.0, envs.action_space.shape or ()).astype(np.float32)
    shares = []
    for _ in range(min(ARMS_IN_ALL // count, 200)):
        alone = _seconds(lambda: envs.batch.step(actions, cycles))
        shares.append(alone / _seconds(lambda: envs.step(actions)))
    envs.close()
    return float(np.median(shares))


def measure() -> dict[str, float]:
    """All figures by name."""
    return {
        "gym_share_of_batch": share_of_batch("Reach", 4096),
        "gym_64_share_of_batch": min(share_of_batch(task, 64) for task in ARM_TASKS),
        "gym_each_cycle_share_of_batch": share_of_batch("Reach", 4096, cycles=1, delay=0),
    }


MEANING = {
    "gym_share_of_batch": "arm-cycles a second of the vector environment by those of its batch, 4096 arms; aim 0.7",
    "gym_64_share_of_batch": "the same with 64 arms, the least of all tasks; aim 0.7",
    "gym_each_cycle_share_of_batch": "the same with 4096 arms and an action a control cycle",
}
