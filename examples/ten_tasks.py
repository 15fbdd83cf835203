"""
Ten usual tasks
===============

Each of the ten tasks that layflat is used for most, in five lines or fewer.
"""

import numpy as np

import layflat as lf

# %%
# Load
# ----
# A machine is a built-in name, or the path of a description of your own.

arm = lf.load("paper-arm")
arm.plot()

# %%
# Change
# ------
# Any value by its path; texts have units, numbers are in SI units.

heavier = lf.changed(arm, "arm.payload", "2 kg")
heavier = lf.changed(heavier, "joint.small.brake.torque", "3 N m")

# %%
# Simulate
# --------
# The large joint steps from -20 to 20 degrees after half a second.

run = lf.rollout(arm, [("0 s", {"large": "-20 deg"}), ("0.5 s", {"large": "20 deg"})], duration="2 s")
run

# %%
# Plot
# ----

run.plot()

# %%
# Measure
# -------
# Settling time, overshoot, steady error and ripple of every joint in every move, the tip's, and the air used.

lf.metrics(run)

# %%
# Vary
# ----
# The same step with 64 payloads, on all cores.

step = lf.Scenario(demand={"large": "20 deg"}, start={"large": "-20 deg"}, duration="1.5 s")
many = lf.ensemble(arm, step, {"arm.payload": np.linspace(0.5, 3.0, 64)}, metrics=("settling", "overshoot"))
many.plot()

# %%
# Size
# ----
# From torque, stroke and pressure to hose, cylinder, cam and strap, as a machine that can be simulated.

joint = lf.size_joint(lf.SizingRequest(torque="25 N m", stroke="120 deg", supply="4 bar"))
joint.plot()

# %%
# Tune
# ----
# Three generations of the search; by default it takes as many as it needs. Its result is a machine like any other.

tuned = lf.tune.tune_controller("paper-small-joint", generations=3, start="current", out="build/tune")
tuned.plot()

# %%
# Identify
# --------
# A joint whose brake is stronger than described: its log tells by how much.

strong = lf.changed(lf.load("paper-small-joint"), "joint.small.brake.torque", "3 N m")
log = lf.save(lf.rollout(strong, [("0.2 s", "20 deg"), ("1.2 s", "-20 deg")], duration="3 s"), "build/measured.nc")
found = lf.identify.fit_logs(log, "paper-small-joint", blocks="friction", starts=0)
found.plot()

# %%
# Plan a motion
# -------------
# Lines, arcs and splines of the tip, as quickly as hoses and valves can; the simulated arm follows them.

plan = lf.plan_motion("paper-arm-tracking", "tour")
followed = lf.rollout(plan.machine, scenario=plan.scenario)
plan.plot()
