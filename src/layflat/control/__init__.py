"""Control laws, of any kind, for the whole arm. A new kind is one folder and one line here; see docs/kinds.md."""

from layflat.control import paper, tracking
from layflat.control.contract import Command, Demand, Sensed
from layflat.control.kind import ControlKind, ControllerPart, voltages_alone
from layflat.kinds import Table
from layflat.physics.adjustable import FULL, Shares

CONTROL_LAWS: Table[ControlKind] = Table("control law", paper.KIND, tracking.KIND)

wake = CONTROL_LAWS.law("wake")
step = CONTROL_LAWS.law("step")
centre_shift = CONTROL_LAWS.law("centre_shift")

__all__ = [
    "CONTROL_LAWS",
    "FULL",
    "Command",
    "ControlKind",
    "ControllerPart",
    "Demand",
    "Sensed",
    "Shares",
    "centre_shift",
    "step",
    "voltages_alone",
    "wake",
]
