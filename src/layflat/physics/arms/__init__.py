"""The rigid arm, of any kind. A new kind is one file and one line here; see docs/kinds.md."""

import numpy as np

from layflat.jit import composition, kernel
from layflat.kinds import Table
from layflat.lanes import gather
from layflat.physics.arms import planar
from layflat.physics.arms.kind import NONE, ArmKind, ArmLaws, ArmPart

ARMS: Table[ArmKind] = Table("arm", planar.KIND)

dynamics = ARMS.law("dynamics")
points = ARMS.law("points")


@composition
def tip(arm, angles):
    """Position of the tip (m), x along link 1 at mid-stroke, from a tuple of the joints' angles."""
    return points(arm, angles)[-1]


@kernel
def tips_along(arm, like, q):
    """Positions of the tip, (instants, 2), m, from angles (instants, joints), rad; `like`: a tuple, an item a joint."""
    tips = np.empty((len(q), 2))
    for i in range(len(q)):
        tips[i, 0], tips[i, 1] = tip(arm, gather(like, q[i]))
    return tips


__all__ = ["ARMS", "NONE", "ArmKind", "ArmLaws", "ArmPart", "dynamics", "points", "tip", "tips_along"]
