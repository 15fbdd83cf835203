"""
An arm that lifts what it does not know
=======================================

This example shows how an arm under gravity takes up an unknown load: its controller is not told the payload, and is
back at its place within half a second after a weight comes.
"""

import matplotlib.pyplot as plt

import layflat as lf

# %%
# The picking arm has four joints. It holds still; after a second its gripper is given 0.8 kg, which it puts down later.
run = lf.rollout(
    "picking-arm", {"base": "0 deg", "shoulder": "10 deg", "elbow": "-10 deg", "wrist": "0 deg"},
    payload=[("0 s", "0 kg"), ("1 s", "0.8 kg"), ("2.5 s", "0 kg")], duration="4 s",
)  # fmt: skip

# %%
sag = 1e3 * (run["tip"] - run["tip"].sel(time=0.9, method="nearest"))
height = sag.sel(axis="z")
print(f"the tip sinks by {-float(height.min()):.1f} mm and rises by {float(height.max()):.1f} mm at most")
for begin, end in ((1.0, 2.5), (2.5, 4.0)):
    part = height.sel(time=slice(begin, end))
    late = float(part["time"][abs(part) > 2.0][-1]) if bool((abs(part) > 2.0).any()) else begin
    print(f"change at {begin} s: within 2 mm after {late - begin:.2f} s")

# %%
figure, (heights, pressures) = plt.subplots(2, 1, sharex=True, layout="constrained")
heights.plot(run["time"], height, "C0-")
heights.axhspan(-2.0, 2.0, color="0.9")
for joint, style in (("shoulder", "C0-"), ("elbow", "C1--"), ("wrist", "C2-.")):
    part = run.sel(joint=joint)
    pressures.plot(run["time"], (part["pressure_a"] - part["pressure_b"]) / 1e5, style, label=joint)
heights.set(ylabel="Height of the tip (mm)", title="A weight of 0.8 kg from 1 s to 2.5 s; grey: ±2 mm")
pressures.set(xlabel="Time (s)", ylabel="Differential pressure (bar)")
pressures.legend()
plt.show()
