"""
A planned way of the tip
========================

This example shows a line, an arc and a way back of the tip of the picking arm with its four joints, as planned, and
how far the simulated arm is from it.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# Segments go from rest to rest, within what hoses and valves can do. Points are those of the tip, x, y and z.
plan = lf.plan_motion(
    "picking-arm",
    [
        {"kind": "line", "to": ["650 mm", "200 mm", "350 mm"], "time_optimal": True},
        {
            "kind": "arc",
            "through": ["650 mm", "0 mm", "450 mm"],
            "to": ["650 mm", "-200 mm", "350 mm"],
            "time_optimal": True,
        },
        {"kind": "joint", "to": ["0 deg", "20 deg", "-20 deg", "0 deg"], "time_optimal": True},
    ],
    start=["0 deg", "20 deg", "-20 deg", "0 deg"],
)
for segment, begin in zip(plan.segments, plan.trajectory.start_times, strict=True):
    peaks = plan.segment_peaks(segment)
    print(f"{segment.kind:5s} from {begin:.2f} s: up to {peaks.tip_speed:.2f} m/s and {peaks.torque:.0%} of the torque")

# %%
# The demand has the angles of each control cycle, with their velocities and accelerations.
run = lf.rollout("picking-arm", scenario=plan.scenario)
tip = 1e3 * run["tip"]  # mm
begin, end = plan.trajectory.start_times[1:3]
arc = tip.sel(time=slice(begin, end))
off = np.hypot(np.hypot(arc.sel(axis="y"), arc.sel(axis="z") - 200.0) - 250.0, arc.sel(axis="x") - 650.0)
print(f"on the arc the tip is at most {float(off.max()):.1f} mm from its circle")

# %%
# Seen against x: the circle through the three points has its centre at y = 0, z = 200 mm.
figure, axes = plt.subplots(layout="constrained")
angle = np.radians(np.linspace(36.87, 143.13, 100))
axes.plot(250.0 * np.cos(angle), 200.0 + 250.0 * np.sin(angle), "0.7", linewidth=5.0, label="planned arc")
axes.plot(tip.sel(axis="y"), tip.sel(axis="z"), "C0-", label="simulated tip")
axes.plot([200, 0, -200], [350, 450, 350], "ko", fillstyle="none", label="points of the plan")
axes.set(xlabel="y of the tip (mm)", ylabel="z of the tip (mm)", aspect="equal")
axes.set_title(f"Line, arc and way back of the tip in {plan.trajectory.duration:.2f} s")
axes.legend()
plt.show()
