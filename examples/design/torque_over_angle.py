"""
Torque of a hose over the angle
===============================

This example shows why the paper's joints have a cam: on a round roller a hose's torque falls with the angle, on a cam
it is the same everywhere, with the same work.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# A design evaluates a described joint: Eq. (1) of the paper gives the force of the hose over its travel.
design = lf.design_joint("paper-arm", "large")
roller_angle, roller_torque = design.roller_torque
cam_angle, cam_torque = design.torque

# %%
work = np.trapezoid(roller_torque, roller_angle)
print(f"on a roller: {roller_torque[0]:.0f} N m at the start, {roller_torque[-1]:.0f} N m at the end")
print(f"on the cam: {cam_torque[0]:.1f} N m at every angle over {np.degrees(design.stroke):.0f} deg")
print(f"work of a stroke: {work:.0f} J on the roller, {cam_torque[0] * cam_angle[-1]:.0f} J on the cam")

# %%
# The paper's joints use 120 deg of this stroke; both hoses share it, one empties as the other fills.
figure, axes = plt.subplots(layout="constrained")
axes.plot(
    np.degrees(roller_angle), roller_torque, "C0-", label=f"round roller of {1e3 * design.joint.output.radius:.0f} mm"
)
axes.plot(np.degrees(cam_angle), cam_torque, "C1--", label="cam")
axes.set(
    xlabel="Angle from the collapsed hose (deg)", ylabel="Torque (N m)",
    title=f"One hose of the large joint at {design.pressure / 1e5:.0f} bar", ylim=(0, None),
)  # fmt: skip
axes.legend()
plt.show()
