"""
Repeatability of the tip
========================

This example shows how near to each other the ends of a hundred moves to the same place are, from either side: what
sensors' noise, friction and the brake leave of an error.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# Fifty moves come from one side, fifty from the other, each with its own noise. The paper reports ±2 mm.
arm = lf.load("paper-arm")
sides = {"from below": -20.0, "from above": 20.0}
ends = {}
for name, side in sides.items():
    start = {"large": f"{side} deg", "small": f"{-side} deg"}
    move = lf.Scenario(demand=[("0 s", start), ("0.1 s", {"large": "0 deg", "small": "0 deg"})], duration="2 s")
    many = lf.ensemble(arm, move, {"seed": np.arange(50)}, traces=("angle",))
    ends[name] = many["angle"].isel(time=-1)

# %%
# Small errors of the angles move the tip by the lever arms of the stretched or bent arm: its elbow is at 90 deg.
link = arm.joint["large"].link.length
tips = {}
for name, angle in ends.items():
    large, elbow = angle.sel(joint="large"), angle.sel(joint="large") + angle.sel(joint="small")
    tips[name] = 1e3 * link * np.stack([-elbow, large], axis=-1)  # mm, about the demanded place
    worst = float(np.linalg.norm(tips[name], axis=1).max())
    print(f"{name}: largest distance from the demand {worst:.2f} mm")

# %%
figure, axes = plt.subplots(layout="constrained")
round_about = np.linspace(0.0, 2.0 * np.pi, 200)
axes.plot(2.0 * np.cos(round_about), 2.0 * np.sin(round_about), "0.6", linewidth=1.0, label="2 mm")
for (name, tip), mark in zip(tips.items(), ("C0o", "C1x"), strict=True):
    axes.plot(*tip.T, mark, fillstyle="none", label=name)
axes.set(
    xlabel="Error along x (mm)",
    ylabel="Error along y (mm)",
    title="Ends of 100 moves of 28 cm of the tip",
    aspect="equal",
)
axes.legend(loc="upper right")
plt.show()
