"""
The supply fails in the middle of a move
========================================

This example shows what an arm does when its supply drops from 4 bar to 1 bar while it moves: it still arrives, later
and by less stiff air.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# A supply is a gauge pressure. A weight would make the drop visible at rest, too; the paper's arm moves in a plane.
move = [("0 s", {"large": "-30 deg", "small": "-30 deg"}), ("0.3 s", {"large": "30 deg", "small": "30 deg"})]
runs = {
    "4 bar": lf.rollout("paper-arm", move, duration="4 s"),
    "1 bar from 0.5 s on": lf.rollout("paper-arm", move, supply=[("0 s", "4 bar"), ("0.5 s", "1 bar")], duration="4 s"),
}

# %%
for name, run in runs.items():
    goal = run["tip"][-1]
    distance = np.sqrt(((run["tip"] - goal) ** 2).sum("axis"))
    late = float(run["time"][distance > 5e-3][-1])
    print(f"{name}: the tip is within 5 mm of where it ends {late - 0.3:.2f} s after the step")

# %%
figure, (angles, pressures) = plt.subplots(2, 1, sharex=True, layout="constrained")
for (name, run), lines in zip(runs.items(), (("C0-", "C1-."), ("C0--", "C1:")), strict=True):
    for joint, style in zip(("large", "small"), lines, strict=True):
        angles.plot(run["time"], np.degrees(run["angle"].sel(joint=joint)), style, label=f"{joint} joint, {name}")
    pressures.plot(run["time"], run["pressure_a"].sel(joint="large") / 1e5, lines[0], label=name)
angles.set(ylabel="Angle (deg)", title="A move of 60 deg of both joints, with and without supply")
pressures.set(xlabel="Time (s)", ylabel="Absolute pressure of\nhose A, large joint (bar)")
for place in (angles, pressures):
    place.legend(fontsize="small")
plt.show()
