"""
Angles for a circle of the tip
==============================

This example shows the angles of the four joints that lead the tip of the picking arm around a circle, each
configuration near to the one before, and how much of the strokes they use.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# The circle stands upright, 600 mm in front of the base, with a radius of 150 mm. A position has many configurations.
arm = lf.load("picking-arm")
turn = np.linspace(0.0, 2.0 * np.pi, 181)
circle = np.stack([np.full_like(turn, 0.6), 0.15 * np.sin(turn), 0.2 + 0.15 * np.cos(turn)], axis=-1)  # m
angles = np.degrees(lf.inverse_kinematics(arm, circle))
for joint, column in zip(arm.joints, angles.T, strict=True):
    half = np.degrees(arm.joint[joint].stops.working_stroke) / 2.0
    print(f"{joint:8s} {column.min():6.1f} to {column.max():5.1f} deg, of a stroke of ±{half:.0f} deg")

# %%
# A position out of reach is refused in one line, with the nearest one that can be reached.
try:
    lf.inverse_kinematics(arm, ["1.2 m", "0 m", "0.2 m"])
except lf.InputError as error:
    print(error)

# %%
figure, axes = plt.subplots(layout="constrained")
for joint, column, style in zip(arm.joints, angles.T, ("C0-", "C1--", "C2-.", "C3:"), strict=True):
    axes.plot(np.degrees(turn), column, style, label=joint)
axes.axhspan(-60.0, 60.0, color="0.93", label="working stroke")
axes.set(xlabel="Position on the circle, from its top (deg)", ylabel="Angle of the joint (deg)")
axes.set_title("A circle of 300 mm of the picking arm's tip")
axes.legend(loc="upper right", fontsize="small")
plt.show()
