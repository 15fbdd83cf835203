"""
A log of another recorder
=========================

This example shows how a table that somebody else's recorder wrote becomes signals in SI units: other names, units,
zeros and signs, and rows that are missing.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# A recorder of a test bench writes angles in degrees, clockwise, and gauge pressures in mbar, every 10 ms with jitter.
run = lf.rollout("paper-small-joint", [("0 s", "-20 deg"), ("0.5 s", "20 deg")], duration="2.5 s").sel(joint="small")
random = np.random.default_rng(3)
time = np.sort(0.01 * np.arange(250) + random.uniform(0.0, 2e-3, 250))
keep = (time < 1.5) | (time > 1.6)  # the recorder was busy
table = np.column_stack(
    [1e3 * time, -np.degrees(run["angle"].interp(time=time)), run["pressure_a"].interp(time=time) / 100 - 1013.25]
)
HEAD = "ms;Pos;P1"
MAPPING = """
[time]
column = "ms"
unit = "ms"

[[column]]
from = "Pos"
signal = "angle"
joint = "small"
unit = "deg"
sign = -1

[[column]]
from = "P1"
signal = "pressure_a"
joint = "small"
unit = "mbar"
gauge = true
"""
with tempfile.TemporaryDirectory() as folder:
    file, mapping = Path(folder) / "bench.csv", Path(folder) / "bench.toml"
    np.savetxt(file, table[keep], delimiter=";", header=HEAD, comments="", fmt="%.3f")
    mapping.write_text(MAPPING, encoding="utf-8")
    log = lf.read_log(file, mapping)

# %%
# The log is on an even clock; a gap of a tenth of a second stays open.
gap = int(np.isnan(log["angle"]).sum())
print(f"{log.sizes['time']} samples every {1e3 * log.attrs['log_period']:.1f} ms, of which {gap} are unknown")
print(f"largest pressure in hose A: {float(log['pressure_a'].max()) / 1e5:.2f} bar, absolute")

# %%
figure, (angles, pressures) = plt.subplots(2, 1, sharex=True, layout="constrained")
log = log.sel(joint="small")
angles.plot(run["time"], np.degrees(run["angle"]), "0.7", linewidth=4.0, label="truth")
angles.plot(log["time"], np.degrees(log["angle"]), "C0-", label="log, with its gap")
pressures.plot(run["time"], run["pressure_a"] / 1e5, "0.7", linewidth=4.0)
pressures.plot(log["time"], log["pressure_a"] / 1e5, "C0-")
for place in (angles, pressures):
    place.axvspan(1.5, 1.6, color="0.93", label="rows that are missing")
angles.set(ylabel="Angle (deg)", title="A table of another recorder, read")
pressures.set(xlabel="Time (s)", ylabel="Absolute pressure\nof hose A (bar)")
angles.legend()
plt.show()
