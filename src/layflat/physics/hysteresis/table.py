"""The kinds of hysteresis, and their laws picked by the parameters. A new kind is one file and one line here."""

from layflat.kinds import Table
from layflat.physics.hysteresis import bouc_wen, creep, elasto_slip, maxwell, spectrum
from layflat.physics.hysteresis.kind import HysteresisKind

HYSTERESIS: Table[HysteresisKind] = Table(
    "hysteresis", elasto_slip.KIND, spectrum.KIND, bouc_wen.KIND, maxwell.KIND, creep.KIND
)

at_rest = HYSTERESIS.law("at_rest")
turned = HYSTERESIS.law("turned")
torques = HYSTERESIS.law("torques")
stored = HYSTERESIS.law("stored")
loaded = HYSTERESIS.law("loaded")
