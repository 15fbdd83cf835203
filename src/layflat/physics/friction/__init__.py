"""Dry friction of an output shaft, of any kind. A new kind is one file and one line here; see docs/kinds.md."""

from layflat.jit import law
from layflat.kinds import Table
from layflat.lanes import select
from layflat.physics.friction import coulomb, stribeck
from layflat.physics.friction.kind import FrictionKind, FrictionPart
from layflat.physics.friction.turning import keep, slide

FRICTION: Table[FrictionKind] = Table("friction", coulomb.KIND, stribeck.KIND)

level = FRICTION.law("level")
rub = FRICTION.law(lambda kind: keep if kind.constant else slide)
"""Velocities after friction, and its impulses, tuples; a held joint's velocity is exactly 0.

`rub(friction, M, p, u, B, S)` takes the upper triangle of the mass matrix, and of each joint the momentum that the step
would end with without friction, the velocity before it, and the greatest impulses while it slides and where it rests.
"""


@law
def levels(friction, brake, velocity, extrapolated, pull):
    """Torques at which a joint slides in this step, and up to which it is held where it comes to rest, N m.

    Args: parameters of a kind; torque of the brake, N m; velocity before the step, and extrapolated to its middle,
    rad/s; torques of both hoses, added up, N m. A joint that stands still is held until it slips.
    """
    way = select(velocity > 0.0, extrapolated, -extrapolated)
    speed = select(velocity == 0.0, 0.0, max(way, 0.0))
    load = max(pull, 0.0)
    return level(friction, brake, speed, load), level(friction, brake, 0.0 * speed, load)


__all__ = ["FRICTION", "FrictionKind", "FrictionPart", "level", "levels", "rub"]
