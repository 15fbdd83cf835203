"""
Training a policy for an unknown payload
========================================

This example shows how an evolution strategy of thirty lines trains a policy on the CPU, which sees only what sensors
show and opens the valves itself, and compares it with control laws on arms that none of them knows.

On two cores it takes some minutes; LAYFLAT_GENERATIONS sets how long it learns.
"""

import os

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

GENERATIONS = int(os.environ.get("LAYFLAT_GENERATIONS", "1200"))
PAIRS, EPISODES, HIDDEN, STEPS = 64, 16, 24, 100  # pairs of candidates, episodes of each, hidden units, steps
TASK = "ReachUnknownPayload"


# %%
# A policy is a network of one hidden layer. Beside the observation it gets small errors enlarged, as the last
# millimetres would else be lost beside moves of a metre. Candidates and episodes are rows of the same arrays.
def inputs(observations):
    """Inputs of the network, (candidates, episodes, 15)."""
    error = observations[..., 8:10]
    rates = np.tanh(observations[..., 4:6])
    one = np.ones_like(error[..., :1])
    return np.concatenate([observations[..., :8], np.tanh(5 * error), np.tanh(50 * error), rates, one], axis=-1)


SPLIT = 15 * HIDDEN  # numbers of the first layer


def act(candidates, observations):
    """Actions of each candidate, (candidates, episodes, 2)."""
    first = candidates[:, :SPLIT].reshape(-1, 15, HIDDEN)
    second = candidates[:, SPLIT:].reshape(-1, HIDDEN, 2)
    return np.tanh(np.tanh(inputs(observations) @ first) @ second)


# %%
# The strategy changes the numbers of the policy at random, in pairs of opposite changes, lets all candidates move the
# same arms, and steps along the changes that did better, with Adam's step sizes.
draw = np.random.default_rng(0)
size = SPLIT + 2 * HIDDEN
best = (draw.standard_normal(size) * np.where(np.arange(size) < SPLIT, 15**-0.5, 0.0)).astype(np.float32)
mean = square = np.zeros(size)
envs = lf.gym.ArmVectorEnv(TASK, 2 * PAIRS * EPISODES)
history = []
for generation in range(GENERATIONS):
    left = 1.0 - 0.9 * generation / GENERATIONS  # steps and changes become smaller
    changes = draw.standard_normal((PAIRS, size)).astype(np.float32)
    changes = np.concatenate([changes, -changes])
    candidates = best + 0.05 * left**0.5 * changes
    arms = np.tile(draw.integers(512, size=EPISODES), 2 * PAIRS)
    observations, _ = envs.reset(seed=generation, options={"arms": arms})
    returns = np.zeros(len(arms))
    for _ in range(STEPS):
        actions = act(candidates, observations.reshape(2 * PAIRS, EPISODES, -1))
        observations, rewards, *_ = envs.step(actions.reshape(-1, 2))
        returns += rewards
    by_candidate = returns.reshape(2 * PAIRS, EPISODES).mean(axis=1)
    ranks = np.argsort(np.argsort(by_candidate)) / (2 * PAIRS - 1) - 0.5
    ascent = ranks @ changes / PAIRS
    mean, square = 0.9 * mean + 0.1 * ascent, 0.99 * square + 0.01 * ascent**2
    rate = 0.03 * left * (1.0 - 0.99 ** (generation + 1)) ** 0.5 / (1.0 - 0.9 ** (generation + 1))
    best = (best + rate * mean / (square**0.5 + 1e-8)).astype(np.float32)
    history.append(by_candidate.mean())
envs.close()

# %%
# All are compared on the same 512 other arms, with other machines, payloads, starts and goals. The control laws know
# the described arm with 1.5 kg; the last one also that its payload may be another. A tip has settled when it stays
# within 2 mm.
tracking = lf.load("paper-arm-tracking")
machines = {
    "paper's law": "paper-arm-fast",
    "paper's law, tuned": "paper-arm-fast-tuned",
    "tracking law": tracking,
    "tracking law, payload open": lf.changed(tracking, "controller.payload_std", "0.75 kg"),
    "trained policy": None,
}
near = {}
print(f"{'':28}return  settled  median   95 %   error at the end, 95 %")
for name, machine in machines.items():
    action = "opening" if machine is None else "demand"
    envs = lf.gym.ArmVectorEnv(TASK, 512, machine=machine, action=action, pool_seed=1)
    observations, _ = envs.reset(seed=1, options={"arms": np.arange(512)})
    goals = (observations[:, 0:2] + observations[:, 8:10]) * 75.0 / 60.0  # half the sensor's range over half the stroke
    returns, distances = 0.0, []
    for _ in range(STEPS):
        actions = goals if machine is not None else act(best[None], observations[None])[0]
        observations, rewards, _, _, infos = envs.step(actions)
        returns += rewards.mean()
        distances.append(infos["distance"])
    envs.close()
    inside = np.array(distances) < 0.002
    near[name] = inside.mean(axis=1)
    settling = 0.02 * (1 + STEPS - np.argmin(np.append(inside[::-1], np.zeros((1, 512), bool), axis=0), axis=0))
    settling = np.sort(np.where(inside[-1], settling, np.inf))
    late = 1e3 * np.quantile(distances[-1], 0.95)
    print(
        f"{name:28}{returns:6.1f}  {100 * inside[-1].mean():5.0f} %"
        f"  {settling[256]:4.2f} s  {settling[486]:4.2f} s  {late:5.1f} mm"
    )

# %%
figure, (learning, settled) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
learning.plot(history)
learning.set(xlabel="Generation (1)", ylabel="Mean return of candidates (1)", title="Learning")
for name, fraction in near.items():
    settled.plot(0.02 * np.arange(1, STEPS + 1), 100 * fraction, label=name)
settled.set(xlabel="Time (s)", ylabel="Arms within 2 mm (%)", title="512 arms that none knows")
settled.legend(fontsize="small")
plt.show()
