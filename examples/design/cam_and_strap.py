"""
Cam and strap of a joint
========================

This example shows the exact cam of the paper's small joint as it is cut, with the line of the strap at the beginning,
in the middle and at the end of the stroke.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# The cam keeps the torque constant. Its profile is the envelope of the strap's lines in the frame of the cam.
design = lf.design_joint("paper-small-joint")
cam, outline = design.cam, design.outline
print(f"lever arm of the strap: {1e3 * cam.lever.min():.1f} to {1e3 * cam.lever.max():.1f} mm")
print(f"smallest radius of the profile: {1e3 * cam.smallest_radius:.1f} mm")
print(f"tension of the strap: at most {design.tension.max():.0f} N at {design.pressure / 1e5:.0f} bar")

# %%
# Each line touches the profile where its normal, at an angle eta, meets it: the support function of the cam is the
# lever arm.
figure, axes = plt.subplots(figsize=(5.6, 5.2), layout="constrained")
axes.fill(*(1e3 * outline.points.T), facecolor="0.9", edgecolor="black", linewidth=0.8, label="cam as cut")
axes.plot(*(1e3 * cam.profile.T), "C0-", linewidth=2.5, label="working profile")
axes.add_patch(plt.Circle((0, 0), 0.5e3 * outline.bore, facecolor="white", edgecolor="black", linewidth=0.8))
last = len(cam.travel) - 1
for index, style, name in (
    (0, "C1-", "strap at 0 deg"),
    (last // 2, "C1--", "in mid-stroke"),
    (last, "C1:", "at the end"),
):
    normal = np.array([np.cos(cam.normal[index]), np.sin(cam.normal[index])])
    tangent = np.array([-normal[1], normal[0]])
    ends = 1e3 * (cam.profile[index] + np.outer([0.0, 0.03], tangent))
    axes.plot(*ends.T, style, label=name)
axes.set(xlabel="x in the frame of the cam (mm)", ylabel="y in the frame of the cam (mm)", aspect="equal")
axes.set_title("Cam of the small joint")
axes.legend(fontsize="small")
plt.show()
