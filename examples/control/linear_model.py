"""
A linear model beside the plant
===============================

This example shows the small-signal response of a joint that slides: curves of its linear model, and points measured on
the simulated plant, with all its dither, hysteresis and friction. It needs the extra `control`.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# Near an operating point a plant is a `StateSpace` of python-control, with names and units of all signals.
signals, frequencies = ("small_velocity", "small_voltage"), np.geomspace(0.4, 25.0, 300)
joint = lf.load("paper-small-joint")
models = {
    load: lf.linearize(lf.changed(joint, "arm.payload", load), configuration="20 deg") for load in ("0 kg", "2 kg")
}
print(f"held at {models['2 kg'].operating_point.voltages[0]:.3f} V; {len(models['2 kg'].poles())} poles")

# %%
# Two plants, with sines added to the voltage of one and subtracted from the other's, differ by twice their response.
points = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0)
plant = lf.linear.measure_response(models["2 kg"], points)[signals].complex
ratio = models["2 kg"][signals](2j * np.pi * np.array(points)) / plant
gain, phase = 100.0 * abs(abs(ratio) - 1.0).max(), np.degrees(abs(np.angle(ratio))).max()
print(f"model and plant differ by {gain:.1f} % in gain and {phase:.1f} deg in phase at most")

# %%
figure, (gains, phases) = plt.subplots(2, 1, sharex=True, layout="constrained")
for (load, model), style in zip(models.items(), ("C0--", "C1-"), strict=True):
    response = model[signals](2j * np.pi * frequencies)
    gains.loglog(frequencies, np.degrees(abs(response)), style, label=f"model, payload {load}")
    phases.semilogx(frequencies, np.degrees(np.unwrap(np.angle(response))), style)
gains.loglog(points, np.degrees(abs(plant)), "ko", fillstyle="none", label="plant, payload 2 kg")
phases.semilogx(points, np.degrees(np.unwrap(np.angle(plant))), "ko", fillstyle="none")
gains.set(ylabel="Velocity (deg/s per V)", title="Small joint that slides at 20 deg: from its valve to its velocity")
gains.legend()
phases.set(xlabel="Frequency (Hz)", ylabel="Phase (deg)")
plt.show()
