"""
Planning by trying many futures
===============================

This example shows a planner that knows no law: in each step it copies the state of the arm into 256 others, lets them
try sequences of valve openings, and takes the first opening of the best ones.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# The arm moves by 40 deg with both joints. A step lasts 20 ms; plans look 0.4 s ahead.
ARM, START, GOAL = "paper-arm-fast", np.radians([-20.0, -20.0]), np.radians([20.0, 20.0])
SAMPLES, HORIZON, CYCLES, STEPS, BEST = 256, 20, 4, 50, 24
goal_tip = lf.Batch(ARM, 1, start=GOAL[None]).tip[0]
arm = lf.Batch(ARM, 1, action="opening", start=START[None], precision="single")
futures = lf.Batch(ARM, SAMPLES, action="opening", precision="single")
draw = np.random.default_rng(1)


def cost_of(plans, state):
    """Costs of plans (samples, steps, joints): distances of the tips on the way, in metres, the last ones enlarged."""
    futures.set_state(state.take([0] * SAMPLES))
    costs = np.zeros(SAMPLES)
    for step in range(HORIZON):
        futures.step(plans[:, step], CYCLES)
        distances = np.linalg.norm(futures.tip - goal_tip, axis=1)
        costs += distances + 0.2 * distances / (distances + 0.005)
    return costs


# %%
# The cross-entropy method: draw plans around the last one, keep the best, draw again around those, more narrowly.
plan, distances, spreads = np.zeros((HORIZON, 2)), [], np.full((HORIZON, 2), 0.6)
for _ in range(STEPS):
    state, spread = arm.state(), np.maximum(spreads, 0.1)
    for _ in range(3):
        changes = draw.standard_normal((SAMPLES, HORIZON // 2, 2)).repeat(2, axis=1)  # held for two steps each
        changes[0] = 0.0
        plans = np.clip(plan + spread * changes, -1.0, 1.0)
        best = plans[np.argsort(cost_of(plans, state))[:BEST]]
        plan, spread = best.mean(axis=0), best.std(axis=0) + 0.01
    arm.step(plan[None, 0], CYCLES)
    distances.append(1e3 * np.linalg.norm(arm.tip[0] - goal_tip))
    plan, spreads = np.append(plan[1:], np.zeros((1, 2)), axis=0), np.append(spread[1:], np.full((1, 2), 0.6), axis=0)

# %%
# The planner has what no controller on a rig has: the exact machine and state.
time = 0.02 * np.arange(1, STEPS + 1)
curves = {"planner": np.array(distances)}
for name, machine in (("paper's law", ARM), ("tracking law", "paper-arm-tracking")):
    run = lf.rollout(machine, [("0 s", tuple(GOAL))], start=tuple(START), duration=time[-1])
    tip = run["tip"].interp(time=time).values
    curves[name] = 1e3 * np.linalg.norm(tip - goal_tip[: tip.shape[1]], axis=1)
for name, curve in curves.items():
    inside = np.flatnonzero(curve > 2.0)[-1] + 1
    settled = f"within 2 mm from {time[inside]:.2f} s on" if inside < STEPS else "not within 2 mm"
    print(f"{name}: {settled}, at the end {curve[-1]:.1f} mm away")

# %%
figure, axes = plt.subplots(layout="constrained")
for (name, curve), style in zip(curves.items(), ("C0-", "C1--", "C2:"), strict=True):
    axes.semilogy(time, curve, style, label=name)
axes.axhline(2.0, color="0.7", linewidth=1.0)
axes.set(xlabel="Time (s)", ylabel="Distance of the tip from its goal (mm)", title="A move of 40 deg of both joints")
axes.legend(fontsize="small")
plt.show()
