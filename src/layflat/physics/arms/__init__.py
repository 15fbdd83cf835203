"""The rigid arm, of any kind. A new kind is one file and one line here; see docs/kinds.md."""

import numpy as np

from layflat.jit import composition, kernel
from layflat.kinds import Table
from layflat.lanes import gather, write_numbers
from layflat.physics.arms import chain, planar
from layflat.physics.arms.kind import NONE, ArmKind, ArmLaws, ArmPart

ARMS: Table[ArmKind] = Table("arm", planar.KIND, chain.KIND)

dynamics = ARMS.law("dynamics")
points = ARMS.law("points")


@composition
def tip(arm, angles):
    """Position of the tip (m), in the plane or in space (see `ArmLaws`), from a tuple of the joints' angles."""
    return points(arm, angles)[-1]


@composition
def _of_plane(arm, angles):
    x, y = points(arm, angles)[-1]
    return x, y, 0.0 * x


tip_in_space = ARMS.law(lambda laws: tip if laws.axes == 3 else _of_plane)
"""As `tip`, with three coordinates whatever the arm."""


@kernel
def tips_along(arm, like, q):
    """Positions of the tip, (instants, axes), m, from angles (instants, joints), rad; `like`: an item a joint."""
    tips = np.empty((len(q), len(tip(arm, like))))
    for i in range(len(q)):
        write_numbers(tips[i], tip(arm, gather(like, q[i])))
    return tips


__all__ = ["ARMS", "NONE", "ArmKind", "ArmLaws", "ArmPart", "dynamics", "points", "tip", "tip_in_space", "tips_along"]
