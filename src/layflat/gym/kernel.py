"""Kernels of the environments: actions and loads of many arms, what they show of themselves, and their rewards.

Numbers are computed in the precision of the arrays that they come from, and rows of observations are float32.
"""

from math import isnan, sqrt
from typing import NamedTuple

import numpy as np

from layflat.gym.rewards import step_reward
from layflat.jit import portable_kernel


class ObservedArrays(NamedTuple):
    """Arrays that are observed, in the precision of the arms; those of arms may be padded."""

    seen: np.ndarray  # readings of angle (rad) and differential pressure (Pa), and others, (joints, signals, arms)
    tips: np.ndarray  # positions of the tips, m, (3, arms)
    goals: np.ndarray  # angles of the pool's goals, rad, (instants, joints, pool)
    goal_tips: np.ndarray  # positions of the tip there, m, (instants, 3, pool)
    of_pool: np.ndarray  # goal of each arm, (arms,)
    steps: np.ndarray  # of each arm's episode: the goal's instant, or the last one after it, (arms,)
    scales: np.ndarray  # one by the units of angle and pressure, L and l of the reward, distance of success, (5,)


class StepArrays(NamedTuple):
    """Arrays that a step writes."""

    rows: np.ndarray  # observations, float32, (rows, arms)
    last: np.ndarray  # angles from which the coming rates are counted, float32, (joints, arms)
    rates: np.ndarray  # units of the angle and 1 rad by those of rates in a step, float32, (2,)
    action: np.ndarray  # float32, (joints, arms)
    distances: np.ndarray  # of the tips from their goals, m, in the precision of the arms, (arms,)
    rewards: np.ndarray  # likewise
    successes: np.ndarray  # whether the tip is at its goal, (arms,)


@portable_kernel(results=1)
def scale_actions(actions, middle, half, scaled, clipped):
    """Clip actions, scale them to the range of the joints, and return how many are no numbers.

    Args: actions, (arms, joints); middle and half of the range of each joint, (joints,); their product and sum, in the
    unit of the batch's kind of action, (arms, joints), and the clipped actions, (joints, arms), which are filled.
    """
    wrong = 0
    for arm in range(len(actions)):
        for j in range(len(middle)):
            value = actions[arm, j]
            value = -1.0 if value < -1.0 else 1.0 if value > 1.0 else value
            wrong += isnan(value)
            clipped[j, arm] = value
            scaled[arm, j] = value if half[j] == 1.0 and middle[j] == 0.0 else middle[j] + half[j] * value
    return wrong


@portable_kernel()
def push_joints(torques, begins, steps, acting, load):
    """Write the torques that push the joints in the present steps.

    Args: first and second torques, (2, joints, arms), N m; steps at which they begin, (2, arms); present steps,
    (arms,); items of `JointSignals`, (joints, signals, padded arms), and the number of the load among them.
    """
    for j in range(torques.shape[1]):
        for arm in range(len(steps)):
            torque = torques[1, j, arm] if steps[arm] >= begins[1, arm] else torques[0, j, arm]
            acting[j, load, arm] = torque if steps[arm] >= begins[0, arm] else 0.0


@portable_kernel()
def read_sensors(observed, step, keeps):
    """Write the blocks angle, pressure and rate; where `keeps` is 1, coming rates are counted from these angles.

    Args: `ObservedArrays`; `StepArrays`; 1 or 0.
    """
    rows, last, n = step.rows, step.last, len(step.last)
    for j in range(n):
        for arm in range(rows.shape[1]):
            rows[j, arm] = observed.seen[j, 0, arm] * observed.scales[0]
            rows[n + j, arm] = observed.seen[j, 1, arm] * observed.scales[1]
            rows[2 * n + j, arm] = rows[j, arm] - last[j, arm]
            rows[2 * n + j, arm] *= step.rates[0]
            if keeps:
                last[j, arm] = rows[j, arm]


@portable_kernel()
def compare_with_goals(observed, step, first):
    """Write action, error and the rate of goals that move, distances from goals, and rewards.

    Args: `ObservedArrays`; `StepArrays`, whose rows have their angles; number of the first row of the actions.
    """
    rows, goals, tips, n, end = step.rows, observed.goals, observed.goal_tips, len(step.last), len(observed.goals) - 1
    for arm in range(rows.shape[1]):
        k, of_pool = min(observed.steps[arm], end), observed.of_pool[arm]
        for j in range(n):
            error = first + n + j
            rows[first + j, arm] = step.action[j, arm]
            rows[error, arm] = goals[k, j, of_pool] * observed.scales[0]
            rows[error, arm] -= rows[j, arm]
            if end > 0:
                rows[error + n, arm] = goals[min(k + 1, end), j, of_pool] - goals[k, j, of_pool]
                rows[error + n, arm] *= step.rates[1]
        x = observed.tips[0, arm] - tips[k, 0, of_pool]
        y = observed.tips[1, arm] - tips[k, 1, of_pool]
        z = observed.tips[2, arm] - tips[k, 2, of_pool]
        step.distances[arm] = sqrt(x * x + y * y + z * z)
        step.rewards[arm] = step_reward(step.distances[arm], observed.scales[2], observed.scales[3])
        step.successes[arm] = step.distances[arm] < observed.scales[4]
