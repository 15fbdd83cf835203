"""
The quickest move
=================

This example shows the quickest move between two configurations, limited by the torque of the hoses and by how fast
valves change it, and the same move with a limit of the speed of the tip.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# A third of each joint's torque is left to feedback. A limit belongs to a segment.
start = ["-30 deg", "-20 deg"]
move = {"kind": "joint", "to": ["30 deg", "20 deg"], "time_optimal": True}
plans = {
    "as quick as it can": lf.plan_motion("paper-arm-tracking", [move], start=start),
    "tip at most 1 m/s": lf.plan_motion("paper-arm-tracking", [move | {"speed": "1 m/s"}], start=start),
}
runs = {name: lf.rollout("paper-arm-tracking", scenario=plan.scenario) for name, plan in plans.items()}

# %%
for name, plan in plans.items():
    error = np.degrees(runs[name]["angle"] - runs[name]["demand"])
    print(
        f"{name}: {plan.trajectory.duration:.2f} s; the simulated joints stay within {float(abs(error).max()):.2f} deg"
    )

# %%
figure, (speeds, torques) = plt.subplots(2, 1, sharex=True, layout="constrained")
for (name, plan), style in zip(plans.items(), ("C0-", "C1--"), strict=True):
    tip = runs[name]["tip"].differentiate("time")
    speeds.plot(tip["time"], np.hypot(tip.sel(axis="x"), tip.sel(axis="y")), style, label=name)
    times = np.linspace(0.0, plan.trajectory.duration, 300)
    shares = plan.capabilities.torque_fractions(plan.torques(plan.trajectory, times))
    torques.plot(times, 100.0 * shares.max(axis=1), style)
torques.axhline(65.0, color="0.6", linewidth=1.0)
speeds.set(ylabel="Speed of the tip (m/s)", title="A move of 60 and 40 deg with 1.5 kg")
torques.set(xlabel="Time (s)", ylabel="Torque of the joint\nthat uses most (%)", ylim=(0, 100))
speeds.legend()
plt.show()
