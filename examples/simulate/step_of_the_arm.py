"""
Step of the paper's arm
=======================

This example shows how the two joints of the paper's arm move, one after the other, and how soon each settles.
The second move begins after half of the payload is put down.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# A demand is a list of steps: instants, and the angles of the joints from then on. A joint that a step does not name
# keeps its demand. Disturbances, such as the payload, are written in the same way.
run = lf.rollout(
    "paper-arm",
    [("0 s", {"large": "-20 deg"}), ("0.5 s", {"large": "20 deg"}), ("2.5 s", {"small": "30 deg"})],
    payload=[("0 s", "1.5 kg"), ("2.5 s", "0.5 kg")],
    duration="4.5 s",
)

# %%
# A run is a data set of xarray: signals by time and joint, in SI units.
error = np.degrees(run["angle"] - run["demand"])
for joint, begin in (("large", 0.5), ("small", 2.5)):
    outside = run["time"][abs(error.sel(joint=joint)) > 0.3]
    print(f"{joint} joint: within 0.3 deg of its demand after {float(outside[-1]) - begin:.2f} s")

# %%
# The large joint moves first; when it swings, the small one, which is to stand still, is pushed by half a degree.
figure, (angles, errors) = plt.subplots(2, 1, sharex=True, layout="constrained")
for joint, style in (("large", "C0-"), ("small", "C1--")):
    angles.plot(run["time"], np.degrees(run["angle"].sel(joint=joint)), style, label=f"{joint} joint")
    angles.plot(run["time"], np.degrees(run["demand"].sel(joint=joint)), "0.6", linewidth=1.0, zorder=0)
    errors.plot(run["time"], error.sel(joint=joint), style)
errors.axhspan(-0.3, 0.3, color="0.9", label="±0.3 deg")
angles.set(ylabel="Angle (deg)", title="Steps of 40 deg and 30 deg; demands in grey")
errors.set(xlabel="Time (s)", ylabel="Error (deg)", ylim=(-3, 3))
angles.legend()
errors.legend()
plt.show()
