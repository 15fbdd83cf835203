"""
Following a moving target
=========================

This example shows how two controllers follow a demand that never rests: the paper's law lags behind, the tracking law,
which knows the machine and the velocity of the demand, stays within a degree.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# Both joints of the arm follow sines. The demand is an array with a row for each control cycle.
arms = {"the paper's law": lf.load("paper-arm"), "tracking law": lf.load("paper-arm-tracking")}
time = np.arange(0.0, 4.0, 5e-3)
rate = 2.0 * np.pi * np.array([0.5, 0.8])  # rad/s
size = np.radians([30.0, 20.0])
demand = size * np.sin(rate * time[:, None])
velocity = size * rate * np.cos(rate * time[:, None])
runs = {name: lf.rollout(arm, demand, demand_velocity=velocity, duration=4.0) for name, arm in arms.items()}

# %%
for name, run in runs.items():
    error = np.degrees(run["angle"] - run["demand"]).sel(time=slice(1.0, None))
    rms = np.sqrt((error**2).mean("time"))
    print(f"{name}: rms error {float(rms[0]):.2f} deg of the large joint, {float(rms[1]):.2f} deg of the small one")

# %%
figure, (angles, errors) = plt.subplots(2, 1, sharex=True, layout="constrained")
for (name, run), style in zip(runs.items(), ("C1--", "C0-"), strict=True):
    large = run.sel(joint="large")
    angles.plot(run["time"], np.degrees(large["angle"]), style, label=name)
    errors.plot(run["time"], np.degrees(large["angle"] - large["demand"]), style)
angles.plot(time, np.degrees(demand[:, 0]), "0.6", linewidth=1.0, zorder=0, label="demand")
angles.set(ylabel="Angle (deg)", title="The large joint; the small one moves as well")
errors.set(xlabel="Time (s)", ylabel="Error (deg)")
angles.legend(fontsize="small")
plt.show()
