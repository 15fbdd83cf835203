"""
A joint with and without brake
==============================

This example shows why a pneumatic joint has a friction brake: without it, a joint swings about its demand for seconds.
Air is a spring, and a spring with a mass oscillates unless something takes its energy.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# The paper's small joint lifts nothing; it turns 2 kg in the horizontal plane. A share of 1 is the whole brake.
step = [("0 s", "-20 deg"), ("0.5 s", "20 deg")]
runs = {share: lf.rollout("paper-small-joint", step, brake=share, duration="4 s") for share in (1.0, 0.3, 0.0)}

# %%
# The last instant outside a band of ±0.3 deg is the end of the move.
for share, run in runs.items():
    error = np.degrees(run["angle"] - run["demand"]).squeeze()
    last = float(run["time"][abs(error) > 0.3][-1])
    print(f"brake at {100 * share:3.0f} %: outside ±0.3 deg until {last - 0.5:.2f} s after the step")

# %%
figure, axes = plt.subplots(layout="constrained")
for (share, run), style in zip(runs.items(), ("C0-", "C1--", "C2:"), strict=True):
    axes.plot(run["time"], np.degrees(run["angle"]), style, label=f"brake at {100 * share:.0f} %")
axes.plot(run["time"], np.degrees(run["demand"]), "0.6", linewidth=1.0, zorder=0, label="demand")
axes.set(xlabel="Time (s)", ylabel="Angle (deg)", title="The small joint with 2 kg, a step of 40 deg")
axes.legend()
plt.show()
