"""Table 1 of the paper, computed as the paper computed it: crude numeric integration with rounded constants.

| symbol | meaning | unit |
|---|---|---|
| P | gauge pressure | Pa |
| R, r | radius of the outer cylinder, of the round inner roller | m |
| R_h | radius of the fully inflated hose | m |
| g | wrap angle of the collapsed hose (gamma) | rad |
| a | contact angle (alpha) | rad |
| b | angle of the round roller | deg |
| A, B, C, D, Z | intermediate values: Z = (B - C D)/A and T = Z P R r / 2 | 1, m, m, 1, m |

The footnote of the printed table gives C and D wrongly; C = R (g - a)/2 and D = 1 - cos a reproduce every row. All of
it rests on pi = 3.14. For exact work use `layflat.design.cam`.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from layflat.arrays import Array
from layflat.physics.hose import inflated_radius, roller_torque


@dataclass(frozen=True)
class Table1Constants:
    """Constants of the printed table; the defaults are the paper's."""

    pressure: float = 4e5
    cylinder_radius: float = 0.0762
    roller_radius: float = 0.026
    hose_width: float = 0.16
    wrap: float = 2.094
    contact_step: float = 0.0628
    roller_step_deg: float = 13.32
    rows: int = 11
    pi: float = 3.14


@dataclass(frozen=True)
class Table1:
    """Columns of Table 1, each of shape (rows,), in the printed order, named by symbol and unit."""

    columns: dict[str, Array]

    @property
    def mean_torque(self) -> float:
        """Total work of the stroke divided by the stroke, N m."""
        return float(self.columns["work_Nm_deg"].sum() / self.columns["b_deg"][-1])


def table1(constants: Table1Constants | None = None) -> Table1:
    """Compute Table 1, by default with the paper's constants.

    Source: the paper's Table 1 and its footnotes, corrected as the head of this file says.
    """
    k = constants or Table1Constants()
    R, r, g = k.cylinder_radius, k.roller_radius, k.wrap
    row = np.arange(k.rows, dtype=np.float64)
    a = g - k.contact_step * row
    A = np.full(k.rows, np.cos((k.pi - g) / 2))
    D = 1.0 - np.cos(a)
    R_h = k.hose_width / k.pi
    # Eq. (1) holds the true pi: in the width of the hose, pi R_h, and in the denominator, which is A.
    law = np.array([roller_torque(k.pressure, R, r, inflated_radius(k.hose_width), g, float(alpha)) for alpha in a])
    T = law * np.cos((pi - g) / 2) / A
    b = k.roller_step_deg * row
    work = np.append(0.0, (T[1:] + T[:-1]) / 2 * k.roller_step_deg)
    move = b * r * k.pi / 180
    force = T / r
    mean = work.sum() / b[-1]
    cam_radius = mean / force
    cam_angle = np.append(0.0, np.cumsum(np.diff(move) / ((cam_radius[1:] + cam_radius[:-1]) / 2)))
    columns = {
        "gamma_rad": np.full(k.rows, g),
        "alpha_rad": a,
        "A": A,
        "B": k.pi * R_h * D,
        "C_m": R * (g - a) / 2,
        "D": D,
        "Z": 2 * T / (k.pressure * R * r),
        "b_deg": b,
        "T_Nm": T,
        "work_Nm_deg": work,
        "move_m": move,
        "force_N": force,
        "cam_radius_m": cam_radius,
        "cam_angle_rad": cam_angle,
        "cam_angle_deg": cam_angle * 180 / k.pi,
        "output_torque_Nm": force * cam_radius,
    }
    return Table1(columns)
