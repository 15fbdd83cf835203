"""From a described machine to the parameters of the laws: the one place where units of design become those of physics.

A number of the machine may be an array, an item a run (see sim/ensemble); then so are the parameters it decides.
"""

from layflat.machine.parameters.arms import Arm, arm, surroundings
from layflat.machine.parameters.controllers import gains, idle_gains
from layflat.machine.parameters.drives import drive_parts, spool_valve
from layflat.machine.parameters.hoses import (
    NO_HOSE,
    full_travel,
    hose,
    loss,
    loss_share,
    stroke,
    torque_constant,
    travel_volume,
)
from layflat.machine.parameters.joints import check_inside_stroke, joints
from layflat.machine.parameters.watches import air_parts

__all__ = [
    "NO_HOSE",
    "Arm",
    "air_parts",
    "arm",
    "check_inside_stroke",
    "drive_parts",
    "full_travel",
    "gains",
    "hose",
    "idle_gains",
    "joints",
    "loss",
    "loss_share",
    "spool_valve",
    "stroke",
    "surroundings",
    "torque_constant",
    "travel_volume",
]
