"""
Parameter study: brake and payload
==================================

This example shows how much brake is right for how much payload: a map of the time in which the small joint comes
within 1 deg of its demand for good, over 289 joints.

The same study as a file is ``examples/brake-and-payload.toml``; ``layflat study`` runs it, keeps what is done if it is
stopped, and writes a table.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# The columns of a grid, flattened: one number a run.
brakes, payloads = np.linspace(0.0, 4.0, 17), np.linspace(0.0, 4.0, 17)
brake, payload = (grid.ravel() for grid in np.meshgrid(brakes, payloads))
many = lf.ensemble(
    "paper-small-joint",
    lf.Scenario(demand=[("0 s", "-20 deg"), ("0.3 s", "20 deg")], duration="2.5 s"),
    {"joint.small.brake.torque": brake, "scenario.payload": payload},
    band="1 deg",
)

# %%
# A run that does not settle has an infinite time, which a map shows as none.
settling = many["settling"].sel(joint="small").isel(move=-1).to_numpy().reshape(17, 17)
for load in (0, 8, 16):
    best = int(settling[load].argmin())
    print(
        f"{payloads[load]:.0f} kg: within 1 deg in {settling[load, best]:.2f} s with a brake of {brakes[best]:.2f} N m"
    )

# %%
figure, axes = plt.subplots(layout="constrained")
shown = np.where(np.isfinite(settling), settling, np.nan)
drawn = axes.pcolormesh(brakes, payloads, shown, cmap="gray_r", vmin=0.0, vmax=2.0)
lines = axes.contour(brakes, payloads, shown, levels=[1.5], colors="C1", linewidths=1.5)
axes.clabel(lines, fmt="%.1f s")
axes.set(
    xlabel="Torque of the brake (N m)",
    ylabel="Payload (kg)",
    title="The small joint, within 1 deg; white: not within 2.2 s",
)
figure.colorbar(drawn, label="Settling time (s)")
plt.show()
