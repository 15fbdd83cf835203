"""
Stress of a steel strap
=======================

This example shows why a strap is thin and layered: a thick strip breaks by bending over the cam, a thin one by
tension, and layers share the tension without being bent more.
"""

import matplotlib.pyplot as plt
import numpy as np

import layflat as lf

# %%
# Each thickness is a machine with one value changed. The worst of the places where the strap bends counts.
arm = lf.load("paper-arm")
thicknesses = np.linspace(0.02, 0.3, 29)  # mm


def safety(layers: int, thickness: float) -> float:
    """Return the yield stress over the greatest stress of the large joint's strap; not a number if it yields."""
    changed = lf.changed(arm, "joint.large.strap.layers", layers)
    changed = lf.changed(changed, "joint.large.strap.thickness", f"{thickness} mm")
    try:
        return min(stress.safety for stress in lf.design_joint(changed, "large").stresses)
    except lf.DesignError:  # a design that breaks is refused, in one line that says why
        return float("nan")


curves = {layers: [safety(layers, thickness) for thickness in thicknesses] for layers in (1, 2, 4)}
for layers, curve in curves.items():
    best = int(np.nanargmax(curve))
    print(f"{layers} layers: best at {thicknesses[best]:.2f} mm each, yield over stress {curve[best]:.2f}")

# %%
figure, axes = plt.subplots(layout="constrained")
for (layers, curve), style in zip(curves.items(), ("C0-", "C1--", "C2-."), strict=True):
    axes.plot(thicknesses, curve, style, label=f"{layers} layer{'s' if layers > 1 else ''}")
axes.plot(0.1, safety(2, 0.1), "ko", label="the paper: two of 0.1 mm")
axes.set(xlabel="Thickness of a layer (mm)", ylabel="Yield stress over stress (1)", ylim=(1, None))
axes.set_title("Strap of the large joint at 4 bar; lines end where it yields")
axes.legend()
plt.show()
