"""
A hundred arms, each let go when it has arrived
===============================================

This example shows a batch of a hundred joints that lift up to 3 kg: between control cycles the program reads all of
them, and takes away the load of each as soon as it has come to rest.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# Arrays of a batch are live views of all arms: `angle` is read, `inputs` act from the next cycle on.
COUNT, CYCLES, GOAL = 100, 600, np.radians(20.0)
payload = np.linspace(0.0, 3.0, COUNT)
arms = lf.Batch("single-joint-lift", COUNT, vary={"arm.payload": payload}, start="-20 deg")
demand, angles = np.full((COUNT, 1), GOAL), np.empty((CYCLES, COUNT))
calm, release = np.zeros(COUNT), np.full(COUNT, CYCLES)  # cycles at rest so far; cycle at which an arm is let go
for cycle in range(CYCLES):
    arms.step(demand)
    angles[cycle] = arms.angle[:, 0]
    near = (abs(arms.angle[:, 0] - GOAL) < np.radians(0.3)) & (abs(arms.velocity[:, 0]) < np.radians(0.5))
    calm = np.where(near, calm + 1, 0)
    release[(calm == 40) & (release == CYCLES)] = cycle
    arms.inputs["payload"][release == cycle] = 0.0

# %%
# Friction of the brake holds the joint where the load is small. Pressures that carried a heavy one push it up at first.
time, after = arms.cycle * np.arange(1, CYCLES + 1), np.arange(CYCLES)[:, np.newaxis] > release
rise = np.degrees(np.where(after, angles, GOAL).max(axis=0) - GOAL)
away = time[np.where(after & (abs(angles - GOAL) > np.radians(0.5)), np.arange(CYCLES)[:, np.newaxis], 0).max(axis=0)]
arrivals = time[release[release < CYCLES]]
print(f"{len(arrivals)} of {COUNT} arms are let go, after {arrivals.min():.2f} to {arrivals.max():.2f} s")
print(f"up to {payload[rise < 1.0].max():.1f} kg rise by less than 1 deg; all are back at {away.max():.2f} s")

# %%
figure, (courses, rises) = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
for arm, style in zip((10, 50, 80), ("C0-", "C1--", "C2:"), strict=True):
    courses.plot(time, np.degrees(angles[:, arm]), style, label=f"{payload[arm]:.1f} kg")
    courses.plot(time[release[arm]], np.degrees(angles[release[arm], arm]), style[:2] + "o", fillstyle="none")
courses.set(xlabel="Time (s)", ylabel="Angle (deg)", title="Three of the arms (circles: let go)")
courses.legend(loc="lower right")
rises.plot(payload, rise, "C0.")
rises.set(xlabel="Payload (kg)", ylabel="Largest rise above 20 deg (deg)", title="All arms, after the load is gone")
plt.show()
