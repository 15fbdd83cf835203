"""Control laws of the whole arm, of any kind. A new kind is one folder and one line here; see docs/kinds.md."""

from layflat.control import paper, tracking
from layflat.control.kind import ControlKind, ControllerPart, voltages_alone
from layflat.control.signals import Command, Demand, Sensed
from layflat.kinds import KindTable
from layflat.physics.adjustable import FULL_FRACTIONS, DriveFractions

CONTROL_LAWS: KindTable[ControlKind] = KindTable("control law", paper.KIND, tracking.KIND)

wake = CONTROL_LAWS.law("wake")
step = CONTROL_LAWS.law("step")
centre_shift = CONTROL_LAWS.law("centre_shift")

__all__ = [
    "CONTROL_LAWS",
    "FULL_FRACTIONS",
    "Command",
    "ControlKind",
    "ControllerPart",
    "Demand",
    "DriveFractions",
    "Sensed",
    "centre_shift",
    "step",
    "voltages_alone",
    "wake",
]
