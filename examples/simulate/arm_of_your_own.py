"""
An arm of any shape
===================

This example shows how an arm that nobody built is described in forty lines and simulated: a turning base with a
lifting link, of the paper's joints, under gravity.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# A description extends another one. Here joints, valve and supply stay; the arm and its controller are new.
DESCRIPTION = """
extends = "paper-arm-fast"
omits = ["arm", "controller"]
name = "two-in-space"
title = "A turning base with a lifting arm, of the paper's joints"

[controller]
kind = "tracking"                     # needs no gains: all follows from this file
cycle = "5 ms"

[arm]
kind = "chain"
joints = ["large", "small"]           # from base to tip
payload = "0.5 kg"
tool = ["350 mm", "0 mm", "0 mm"]     # of the payload, in the frame of the last link
gravity = ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"]

[arm.link.large]                      # turned by the large joint, about z
axis = [0, 0, 1]
position = ["0 mm", "0 mm", "0 mm"]
mass = "0.4 kg"
centre = ["0 mm", "0 mm", "100 mm"]
inertia = ["0.0014 kg m^2", "0.0014 kg m^2", "0.0003 kg m^2"]
rotor_inertia = "0.003 kg m^2"

[arm.link.small]                      # lifted by the small joint
axis = [0, -1, 0]
position = ["0 mm", "0 mm", "200 mm"]
rotation = ["0 deg", "-30 deg", "0 deg"]
mass = "0.3 kg"
centre = ["175 mm", "0 mm", "0 mm"]
inertia = ["0.0002 kg m^2", "0.0031 kg m^2", "0.0031 kg m^2"]
rotor_inertia = "0.001 kg m^2"
"""
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "two-in-space.toml"
    file.write_text(DESCRIPTION, encoding="utf-8")
    arm = lf.load(file)

# %%
# The arm goes through four configurations and back; both joints begin at once, and each arrives when it can.
corners = [(-40, -20), (40, 30), (40, -20), (-40, 30), (-40, -20)]
demand = [(f"{1.2 * k} s", {"large": f"{turn} deg", "small": f"{lift} deg"}) for k, (turn, lift) in enumerate(corners)]
run = lf.rollout(arm, demand, duration="6 s")
error = np.degrees(run["angle"] - run["demand"])
for joint in arm.joints:
    ends = [float(error.sel(joint=joint).sel(time=1.2 * k + 1.15, method="nearest")) for k in range(5)]
    print(f"{joint} joint: at most {max(map(abs, ends)):.2f} deg off 1.15 s after each demand")

# %%
tip = 1e3 * run["tip"]
bearing = np.degrees(np.arctan2(tip.sel(axis="y"), tip.sel(axis="x")))
figure, axes = plt.subplots(layout="constrained")
axes.plot(bearing, tip.sel(axis="z"), "C0-", label="tip")
for k in range(4):
    end = {"time": 1.2 * k + 1.15, "method": "nearest"}
    axes.plot(
        bearing.sel(**end),
        tip.sel(axis="z").sel(**end),
        "ko",
        fillstyle="none",
        label="1.15 s after each demand" if k == 0 else None,
    )
axes.set(
    xlabel="Bearing of the tip (deg)",
    ylabel="Height of the tip (mm)",
    title="Way of the tip through four configurations",
)
axes.legend()
plt.show()
