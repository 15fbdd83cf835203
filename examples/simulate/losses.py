"""
Laws of losses in hose and strap
================================

This example shows the hysteresis of three laws at two sizes of motion: their large loops are alike, their small ones
are not. Small motions are what a controller meets near its demand.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# A part of a description is replaced as a whole. All three laws lose the same in a large slow motion.
common = {"reference_pressure_gauge": "3 bar", "pressure_free": 0.25}
laws = {
    "elements that slip": {
        "kind": "elasto-slip",
        "deflections": ["1 deg", "4 deg", "12 deg"],
        "weights": [0.4, 0.3, 0.3],
    },
    "spectrum of elements": {"kind": "elasto-slip-spectrum", "first": "0.3 deg", "last": "12 deg", "elements": 12},
    "Bouc and Wen": {"kind": "bouc-wen", "deflection": "3 deg", "beta": 0.9},
}
base = lf.changed(lf.load("paper-small-joint"), "controller", {"kind": "tracking", "cycle": "5 ms"})
joints = {name: lf.changed(base, "joint.small.losses", common | law) for name, law in laws.items()}

# %%
# The joint, with a controller that follows closely, is led by a slow sine twice, 30 deg or 2 deg to either side. The
# second cycle is drawn.
time = np.arange(0.0, 8.0, base.cycle)


def loop(joint: lf.Machine, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Return angle (deg) and torque of the losses (N m) over the second of two cycles."""
    demand = np.radians(size) * np.sin(2.0 * np.pi * time[:, None] / 4.0)
    velocity = np.radians(size) * np.pi / 2.0 * np.cos(2.0 * np.pi * time[:, None] / 4.0)
    run = lf.rollout(joint, demand, demand_velocity=velocity, duration=8.0, noise=False)
    run = run.sel(joint="small", time=slice(4.0, None))
    return np.degrees(run["angle"].to_numpy()), run["hose_torque"].to_numpy()


loops = {(name, size): loop(joint, size) for name, joint in joints.items() for size in (30.0, 2.0)}
for (name, size), (angle, torque) in loops.items():
    lost = abs(np.trapezoid(torque, np.radians(angle)))
    print(f"{name:20s} ±{size:2.0f} deg: {1e3 * lost:6.1f} mJ lost in a cycle, peak {np.ptp(torque) / 2:.2f} N m")

# %%
figure, axes = plt.subplots(1, 3, sharey=True, figsize=(9.0, 3.6), layout="constrained")
for place, name in zip(axes, laws, strict=True):
    for size, style in ((30.0, "C0-"), (2.0, "C1--")):
        place.plot(*loops[name, size], style, label=f"±{size:.0f} deg")
    place.set(xlabel="Angle (deg)", title=name)
axes[0].set(ylabel="Torque of the losses (N m)")
axes[0].legend()
plt.show()
