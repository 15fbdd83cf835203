"""Dry friction of an output shaft, of any kind. A new kind is one file and one line here; see docs/kinds.md."""

from layflat.jit import law
from layflat.kinds import KindTable
from layflat.lanes import select
from layflat.physics.friction import coulomb, stribeck
from layflat.physics.friction.kind import FrictionKind, FrictionPart
from layflat.physics.friction.turning import solve_constant_friction, solve_varying_friction

FRICTION: KindTable[FrictionKind] = KindTable("friction", coulomb.KIND, stribeck.KIND)

slip_torque = FRICTION.law("level")
solve_friction = FRICTION.law(lambda kind: solve_constant_friction if kind.constant else solve_varying_friction)
"""Velocities after friction, and its impulses, tuples; a held joint's velocity is exactly 0.

`solve_friction(friction, M, p, u, B, S)` takes the upper triangle of the mass matrix, and of each joint the momentum
after the step if there were no friction, the velocity before it, and the maximum impulses while it slides and where it
is at rest.
"""


@law
def slip_torques(friction, brake, velocity, extrapolated, pull):
    """Return the torque at which a joint slides in this step, and that up to which it is held at rest, N m.

    Args: parameters of a kind; torque of the brake, N m; velocity before the step, and extrapolated to its middle,
    rad/s; sum of the torques of both hoses, N m. A joint at rest is held until it slips.
    """
    along = select(velocity > 0.0, extrapolated, -extrapolated)
    speed = select(velocity == 0.0, 0.0, max(along, 0.0))
    load = max(pull, 0.0)
    return slip_torque(friction, brake, speed, load), slip_torque(friction, brake, 0.0 * speed, load)


__all__ = ["FRICTION", "FrictionKind", "FrictionPart", "slip_torque", "slip_torques", "solve_friction"]
