"""A joint's design as tables on the terminal."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from layflat.design import JointDesign

Table = Callable[[list[str], list[list[str]], str], None]

ROWS = 11
"""Rows of the cam's table, as the paper's Table 1 has."""


def print_design(design: JointDesign, table: Table) -> None:
    """Print what was designed, the cam's columns, and the strap's stresses."""
    joint, (angle, torque) = design.joint, design.torque
    rows = [
        ["torque", f"{torque.min():.1f} to {torque.max():.1f} N m at {design.pressure / 1e5:g} bar gauge"],
        ["full travel", f"{degrees(angle[-1]):.1f} deg (working stroke {degrees(joint.stops.working_stroke):.0f} deg)"],
        ["hose", f"{1e3 * joint.hose.width:.0f} mm wide, wrapped {degrees(joint.hose.wrap):.0f} deg"],
        ["cylinder", f"{1e3 * joint.cylinder.diameter:.1f} mm in diameter"],
        ["output", f"{joint.output.kind}, {1e3 * joint.output.radius:.2f} mm mean radius"],
        ["mass", f"{design.mass.body:.2f} kg, of which {design.mass.counted:.2f} kg hose, cylinder, shell, strap, cam"],
        ["air per stroke", f"{design.air.normal_litres:.2f} normal litres"],
    ]
    table(["quantity", "value"], rows, f"{design.machine.name}, {design.name} joint")
    if design.cam is not None:
        columns = design.columns()
        shown = ["travel_mm", "force_N", "tension_N", "lever_mm", "cam_angle_deg", "torque_Nm", "curvature_radius_mm"]
        at = np.linspace(0, len(columns["travel_mm"]) - 1, ROWS).round().astype(int)
        table(shown, [[f"{columns[name][i]:.2f}" for name in shown] for i in at], "cam")
    rows = [
        [s.place, *(f"{value / 1e6:.0f}" for value in (s.tensile, s.bending, s.yield_stress)), f"{s.safety:.2f}"]
        for s in design.stresses
    ]
    table(["strap over", "tension (MPa)", "bending (MPa)", "yield (MPa)", "safety"], rows, "strap")
