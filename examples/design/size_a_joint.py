"""
From a torque to a joint that moves
===================================

This example shows the way from what a joint is to do to a simulated step: a torque, a stroke and a supply pressure
give hose, cylinder, cam, strap and a description, which runs at once.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# Everything that the request does not say is chosen as in the paper's joints.
request = lf.SizingRequest(torque="40 N m", stroke="110 deg", supply="5 bar", name="shoulder")
sized = lf.size_joint(request)
design = sized.design
print(f"hose of {1e3 * design.joint.hose.width:.0f} mm on a cylinder of {1e3 * design.joint.cylinder.diameter:.0f} mm")
print(f"{design.mean_torque:.1f} N m over {np.degrees(design.stroke):.0f} deg")
print(f"strap: yield over stress {min(stress.safety for stress in design.stresses):.2f}")

# %%
# The description has gains and a valve to start with; tuning finds better ones.
runs = {
    f"{payload:.0f} kg": lf.rollout(
        sized.machine, [("0 s", "-20 deg"), ("0.3 s", "20 deg")], payload=payload, duration="3 s"
    )
    for payload in (1.0, 3.0)
}

# %%
figure, axes = plt.subplots(layout="constrained")
for (name, run), style in zip(runs.items(), ("C0-", "C1--"), strict=True):
    axes.plot(run["time"], np.degrees(run["angle"]), style, label=name)
axes.plot(run["time"], np.degrees(run["demand"]), "0.6", linewidth=1.0, zorder=0, label="demand")
axes.set(xlabel="Time (s)", ylabel="Angle (deg)", title="The sized joint, a step of 40 deg with two payloads")
axes.legend(loc="lower right")
plt.show()
