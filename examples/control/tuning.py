"""
Tuning the paper's controller
=============================

This example shows what a short search for gains does to the steps of a joint, with the payload that it was made for
and with others.
"""

import tempfile

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# The search starts from gains that know nothing of the joint, and looks for moves that settle soon over payloads,
# supplies, losses and drifts that differ. Thirty generations take a second or two; by default there are more.
with tempfile.TemporaryDirectory() as folder:
    tuned = lf.tune.tune_controller("paper-small-joint", generations=30, out=folder)

# %%
step = [("0 s", "-20 deg"), ("0.3 s", "20 deg")]
payloads = (1.0, 2.0, 3.0)  # kg
arms = {"before": lf.load("paper-small-joint"), "after": tuned.machine}
runs = {
    (name, kg): lf.rollout(arm, step, payload=kg, duration="2.3 s") for name, arm in arms.items() for kg in payloads
}
for (name, kg), run in runs.items():
    print(f"{name}, {kg:.0f} kg: settled after {float(lf.metrics(run)['settling'].squeeze()):.2f} s")

# %%
figure, axes = plt.subplots(1, 2, sharey=True, figsize=(9.0, 3.8), layout="constrained")
for place, name in zip(axes, arms, strict=True):
    for kg, style in zip(payloads, ("C0-", "C1--", "C2:"), strict=True):
        run = runs[name, kg]
        place.plot(run["time"], np.degrees(run["angle"]), style, label=f"{kg:.0f} kg")
    place.set(xlabel="Time (s)", title=f"The small joint {name} tuning")
axes[0].set(ylabel="Angle (deg)")
axes[0].legend()
plt.show()
