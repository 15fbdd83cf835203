"""From a described machine to the parameters of the laws: the one place where units of design become those of physics.

A number of the machine may be an array, an item a run (see sim/ensemble); then so are the parameters it decides.
"""

from layflat.machine.parameters.arms import arm, mass_and_pull, surroundings
from layflat.machine.parameters.controllers import control
from layflat.machine.parameters.drives import drive_parts
from layflat.machine.parameters.hoses import (
    full_travel,
    hose,
    loss,
    loss_share,
    no_hose,
    stroke,
    torque_constant,
    travel_volume,
)
from layflat.machine.parameters.joints import check_inside_stroke, joints
from layflat.machine.parameters.watches import air_parts

__all__ = [
    "air_parts",
    "arm",
    "check_inside_stroke",
    "control",
    "drive_parts",
    "full_travel",
    "hose",
    "joints",
    "loss",
    "loss_share",
    "mass_and_pull",
    "no_hose",
    "stroke",
    "surroundings",
    "torque_constant",
    "travel_volume",
]
