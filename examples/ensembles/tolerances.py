"""
Tolerances of manufacture
=========================

This example shows how much the steps of five hundred joints differ that are made alike but for tolerances: the band
in which nine of ten lie, and how many settle late.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# Brake, valve and supply differ by normal distributions, the width of the hose and the noise of sensors too.
runs = 500
draw = np.random.default_rng(1).normal
joint = lf.load("paper-small-joint")
small = joint.joint["small"]
many = lf.ensemble(
    joint,
    lf.Scenario(demand=[("0 s", "-20 deg"), ("0.3 s", "20 deg")], duration="2.3 s"),
    {
        "joint.small.brake.torque": small.brake.torque * draw(1.0, 0.1, runs),
        "joint.small.hose.width": small.hose.width * draw(1.0, 0.01, runs),
        "valve.conductance": joint.valve.conductance * draw(1.0, 0.08, runs),
        "supply.pressure_gauge": joint.supply.pressure_gauge * draw(1.0, 0.05, runs),
        "seed": np.arange(runs),
    },
    traces=("angle",),
)

# %%
# A demand that changes once makes a run of two moves: before the step, and after it.
settling = many["settling"].sel(joint="small").isel(move=-1)
print(f"settled within 0.3 deg after {float(settling.median()):.2f} s (median)")
print(
    f"nine of ten after {float(settling.quantile(0.9)):.2f} s, {int(np.isinf(settling).sum())} of {runs} not within 2 s"
)

# %%
angle = np.degrees(many["angle"].sel(joint="small"))
low, middle, high = angle.quantile([0.05, 0.5, 0.95], dim="run")
figure, axes = plt.subplots(layout="constrained")
axes.fill_between(many["time"], angle.min("run"), angle.max("run"), color="0.9", label="all 500")
axes.fill_between(many["time"], low, high, color="0.7", label="nine of ten")
axes.plot(many["time"], middle, "k-", linewidth=1.0, label="median")
axes.set(xlabel="Time (s)", ylabel="Angle (deg)", title="A step of 40 deg of 500 small joints")
axes.legend()
plt.show()
