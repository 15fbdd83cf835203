"""Losses inside hose and strap, of any kind. A new kind is one file and one line here; see docs/kinds.md."""

from layflat.kinds import Table
from layflat.physics.hysteresis import elasto_slip
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart

HYSTERESIS: Table[HysteresisKind] = Table("hysteresis", elasto_slip.KIND)

at_rest = HYSTERESIS.law("at_rest")
turned = HYSTERESIS.law("turned")
torques = HYSTERESIS.law("torques")
stored = HYSTERESIS.law("stored")
loaded = HYSTERESIS.law("loaded")

__all__ = ["HYSTERESIS", "HysteresisKind", "LossesPart", "at_rest", "loaded", "stored", "torques", "turned"]
