"""
Balance of energy of a move
===========================

This example shows where the work of the air goes when a joint makes a step: first into motion, then into heat of the
brake, and partly into hose and strap.
"""

import matplotlib.pyplot as plt

import layflat as lf

# %%
run = lf.rollout("paper-small-joint", [("0 s", "-20 deg"), ("0.3 s", "20 deg")], duration="2 s", noise=False)
run = run.sel(joint="small")

# %%
# All works are recorded from the start of the run on. What is left over is the energy of the motion.
heat = {
    "brake": run["brake_heat"],
    "hose and strap": run["hose_work"],
    "viscous friction and stops": run["damping_heat"],
}
kinetic = run["gas_work"] + run["load_work"] - sum(heat.values())
print(f"work of the air: {float(run['gas_work'][-1]):.2f} J")
for name, part in heat.items():
    print(f"{name}: {float(part[-1]):.2f} J, {float(part[-1] / run['gas_work'][-1]):.0%}")
print(f"greatest energy of the motion: {float(kinetic.max()):.2f} J")

# %%
figure, axes = plt.subplots(layout="constrained")
axes.stackplot(
    run["time"], *heat.values(), kinetic.clip(0.0),
    labels=[*heat, "motion"], colors=["0.25", "0.5", "0.7", "white"], edgecolor="black", linewidth=0.6,
    hatch=["", "///", "", "..."],
)  # fmt: skip
axes.plot(run["time"], run["gas_work"], "C1--", label="work of the air")
axes.set(xlabel="Time (s)", ylabel="Energy (J)", title="A step of 40 deg of the small joint with 2 kg")
axes.legend(loc="lower right")
plt.show()
