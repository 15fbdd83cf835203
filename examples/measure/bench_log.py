"""
Identification from a bench log
===============================

This example shows how a log of a joint tells its friction, each value with a 95 % interval. The log is simulated with
a joint that differs from its description, so that the truth is known.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# The true joint has more brake and viscous friction, a larger valve and longer tubes than the description says.
described = lf.load("paper-small-joint-fast")
small = described.joint["small"]
factors = {
    "joint.small.brake.torque": 1.3,
    "joint.small.brake.viscous": 2.5,
    "joint.small.hose.dead_volume": 1.4,
    "valve.conductance": 1.1,
}
before = {
    "joint.small.brake.torque": small.brake.torque,
    "joint.small.brake.viscous": small.brake.viscous,
    "joint.small.hose.dead_volume": small.hose.dead_volume,
    "valve.conductance": described.valve.conductance,
}
true_joint = described
for path, factor in factors.items():
    true_joint = lf.changed(true_joint, path, factor * before[path])

# %%
# On the bench the joint makes steps, a slow ramp and a swept sine, 24 s in all.
time = np.arange(0.0, 24.0, described.cycle)
steps = 25.0 * np.array([0.0, 0.8, -0.3, 1.0, -1.0, 0.2, -0.6, 0.5])[(time / 1.2).astype(int) % 8]
ramp = 20.0 * np.interp(time, [9.6, 11.6, 15.6, 17.6], [0.0, 1.0, -1.0, 0.0])
sweep = 8.0 * np.sin(2.0 * np.pi * 0.2 * (time - 17.6) ** 2)
demand = np.radians(np.where(time < 9.6, steps, np.where(time < 17.6, ramp, sweep)))
run = lf.rollout(true_joint, demand[:, None], duration=24.0)

# %%
# The fit begins with the description. The last third of the log is not fitted, only predicted.
with tempfile.TemporaryDirectory() as folder:
    log = lf.save(run, Path(folder) / "bench.nc")
    fitted = lf.identify.fit_logs(log, "paper-small-joint-fast", blocks="valve, hose, friction", starts=0, out=folder)
estimates = {path: fitted.fit.estimate(path) for path in factors}
for path, one in estimates.items():
    truth = factors[path] * before[path]
    print(f"{path}: {one.value / truth:.3f} of the truth ({one.low / truth:.3f} to {one.high / truth:.3f})")
angle = next(quality for quality in fitted.fit.qualities() if quality.output == "angle" and quality.validation)
print(f"the last third is predicted to {np.degrees(angle.rms):.3f} deg rms")

# %%
figure, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
for row, (path, one) in enumerate(estimates.items()):
    truth = factors[path] * before[path]
    axes.plot(
        [one.low / truth, one.high / truth],
        [row, row],
        "k-",
        linewidth=2.0,
        label="95 % interval" if row == 0 else None,
    )
    axes.plot(one.value / truth, row, "ko", label="identified" if row == 0 else None)
    axes.plot(1.0 / factors[path], row, "C1s", fillstyle="none", label="described" if row == 0 else None)
axes.axvline(1.0, color="0.6", linewidth=1.0)
axes.set_yticks(range(len(estimates)), [path.removeprefix("joint.small.") for path in estimates])
axes.set(
    xlabel="Value over the truth (1)", ylabel="Parameter (name)", ylim=(-0.6, 3.6), title="Values from one log of 24 s"
)
axes.legend(loc="lower left")
plt.show()
