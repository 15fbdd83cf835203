"""
From a task to an arm
=====================

This example shows how the mass of an arm for one task depends on the time of its moves and on the supply pressure:
joints of a fast arm mostly move themselves.
"""

import matplotlib.pyplot as plt

import layflat as lf

# %%
# A reach and a payload describe a standard arm of four joints: base, shoulder, elbow and wrist.
times, pressures = (0.6, 0.7, 0.8, 1.0, 1.3), (4.0, 6.0)
arms = {
    (pressure, time): lf.size_arm(reach="0.7 m", payload="0.5 kg", supply=f"{pressure} bar", time=f"{time} s")
    for pressure in pressures
    for time in times
}
arm = arms[6.0, 0.8]
for part, need in zip(arm.parts, arm.needs, strict=True):
    width = 1e3 * part.joint.design.joint.hose.width
    print(f"{part.task.name:8s} hose of {width:3.0f} mm, needs {need.torque:4.1f} N m, gives {part.torque:4.1f} N m")
print(f"mass of joints and links: {arm.mass:.1f} kg")

# %%
figure, axes = plt.subplots(layout="constrained")
for pressure, style in zip(pressures, ("C0-o", "C1--s"), strict=True):
    axes.plot(
        times, [arms[pressure, time].mass for time in times], style, fillstyle="none", label=f"{pressure:.0f} bar"
    )
axes.set(
    xlabel="Time of a move of 60 deg (s)", ylabel="Mass of the arm (kg)", title="Arms for 0.5 kg and a reach of 0.7 m"
)
axes.legend()
plt.show()
