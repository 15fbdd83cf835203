"""
Flow and pressure at a valve
============================

This example shows what a proportional valve does with the air of a joint: at full opening, the flow into a hose is
choked until the hose has a certain share of the supply's pressure, and then dies away.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# An opening replaces the controller: the run is in open loop. An opening of 1 lets supply air into hose A, and the air
# of hose B out. A brake of 100 N m holds the joint, so that the volumes stay the same.
joint = lf.changed(lf.load("paper-small-joint"), "joint.small.brake.torque", "100 N m")
run = lf.rollout(
    joint, opening=[("0 s", 0.0), ("0.1 s", 1.0)], dither=0.0, pressures=("1.05 bar", "5 bar"), duration="1.2 s"
)
run = run.sel(joint="small")

# %%
# The air that was taken from the supply, differentiated, is the flow. A normal litre is air at 0 degC and 1.01325 bar,
# 1.293 g. ISO 6358 describes the flow by a conductance and the critical ratio of the pressures.
flow = run["air_taken"].differentiate("time") / 1.293e-3  # normal litres a second
ratio = run["pressure_a"] / run["supply"]
critical = joint.valve.critical_ratio
late = float(run["time"][ratio > 0.9][0]) - 0.1
print(f"greatest flow: {float(flow.max()):.2f} normal litres a second")
print(f"choked up to {critical:.0%} of the supply's pressure, {critical * float(run['supply'][0]) / 1e5:.2f} bar")
print(f"hose A has 90 % of the supply's pressure after {late:.2f} s")

# %%
# The curve of the standard, drawn from the greatest flow and the critical ratio alone, is what the run follows.
figure, (pressures, flows) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
pressures.plot(run["time"], run["pressure_a"] / 1e5, "C0-", label="hose A")
pressures.plot(run["time"], run["pressure_b"] / 1e5, "C1--", label="hose B")
pressures.plot(run["time"], run["supply"] / 1e5, "0.6", linewidth=1.0, label="supply")
pressures.set(xlabel="Time (s)", ylabel="Absolute pressure (bar)", title="Full opening from 0.1 s on")
pressures.legend()
shares = np.linspace(0.2, 1.0, 200)
subsonic = np.sqrt(1.0 - (np.clip(shares - critical, 0.0, None) / (1.0 - critical)) ** 2)
filling = run["time"] > 0.12
flows.plot(shares, float(flow.max()) * subsonic, "0.6", linewidth=4.0, label="ISO 6358")
flows.plot(ratio[filling], flow[filling], "C0-", label="run")
flows.axvline(critical, color="0.3", linestyle=":", label="critical ratio")
flows.set(
    xlabel="Pressure of hose A over the supply's (1)",
    ylabel="Flow from the supply (normal litres/s)",
    title="Flow into hose A",
)
flows.legend()
plt.show()
