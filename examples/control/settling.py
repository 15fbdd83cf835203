"""
Settling, overshoot and ripple
==============================

This example shows how the metrics of a move are defined, drawn at a step of the small joint: settling time, overshoot,
steady error and ripple.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# A joint without much brake swings a little, so that there is something to measure.
begin, end = 0.2, 2.2
run = lf.rollout("paper-small-joint", [("0 s", "-20 deg"), (f"{begin} s", "20 deg")], brake=0.4, duration=end)

# %%
# A move goes from one change of the demand to the next. A joint has settled when it stays within 0.3 deg; steady error
# and ripple are taken over the last fifth of the move.
move = lf.metrics(run).sel(joint="small").isel(move=-1)
settling, overshoot = float(move["settling"]), np.degrees(float(move["overshoot"]))
steady, ripple = np.degrees(float(move["steady_error"])), np.degrees(float(move["ripple"]))
print(f"settling time {settling:.2f} s, overshoot {overshoot:.2f} deg")
print(f"steady error {steady:.3f} deg, ripple {ripple:.3f} deg peak to peak")
print(f"air used: {float(lf.metrics(run)['air_used']):.2f} normal litres")

# %%
error = np.degrees(run["angle"] - run["demand"]).sel(joint="small")
figure, axes = plt.subplots(layout="constrained")
axes.axhspan(-0.3, 0.3, color="0.9", label="settling band, ±0.3 deg")
axes.axvspan(
    end - 0.2 * (end - begin), end, facecolor="none", edgecolor="0.7", hatch="//", label="last fifth of the move"
)
axes.plot(run["time"], error, "C0-")
axes.axhline(overshoot, color="C1", linestyle="--", label=f"overshoot, {overshoot:.2f} deg")
axes.axvline(begin + settling, color="C2", linestyle="-.", label=f"settled, {settling:.2f} s after the step")
axes.set(
    xlabel="Time (s)",
    ylabel="Angle less demand (deg)",
    ylim=(-3.0, 4.5),
    title="A step of 40 deg with 40 % of the brake",
)
axes.legend(fontsize="small", loc="upper left")
plt.show()
