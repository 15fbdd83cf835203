"""Losses inside hose and strap: elasto-slip elements in parallel, which remember where the motion turned.

| symbol | meaning | unit |
|---|---|---|
| f | torque of an element | N m |
| k | its stiffness | N m/rad |
| Y | the torque at which it slips, Y = Y_0 + Y_1 p_g | N m |
| p_g | gauge pressure in the hose | Pa |

An element is a spring in series with a Coulomb slider (Prandtl-Ishlinskii model, Visintin 1994, key visintin1994). For
a motion much smaller than Y/k it is a spring and loses nothing: the reason why such hysteresis damps little.
"""

from typing import NamedTuple

from layflat.jit import law


class Loss(NamedTuple):
    """Three elements: stiffness, slip torque without pressure and slip torque per gauge pressure of each."""

    stiffness_1: float
    stiffness_2: float
    stiffness_3: float
    base_1: float
    base_2: float
    base_3: float
    slope_1: float
    slope_2: float
    slope_3: float


@law
def slip(f, k, Y, turn):
    """Torque of an element after the joint has turned by `turn` rad."""
    return min(max(f + k * turn, -Y), Y)


@law
def slip_all(loss, f_1, f_2, f_3, turn, p_g):
    """Torques of the three elements after a turn at gauge pressure p_g."""
    p_g = max(p_g, 0.0)
    return (
        slip(f_1, loss.stiffness_1, loss.base_1 + loss.slope_1 * p_g, turn),
        slip(f_2, loss.stiffness_2, loss.base_2 + loss.slope_2 * p_g, turn),
        slip(f_3, loss.stiffness_3, loss.base_3 + loss.slope_3 * p_g, turn),
    )


@law
def stored_energy(loss, f_1, f_2, f_3):
    """Energy in the springs of the elements, J; zero for an element without stiffness, which carries no torque."""
    e_1 = f_1 * f_1 / loss.stiffness_1 if loss.stiffness_1 > 0.0 else 0.0
    e_2 = f_2 * f_2 / loss.stiffness_2 if loss.stiffness_2 > 0.0 else 0.0
    e_3 = f_3 * f_3 / loss.stiffness_3 if loss.stiffness_3 > 0.0 else 0.0
    return 0.5 * (e_1 + e_2 + e_3)
