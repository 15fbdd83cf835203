"""Coulomb friction: a joint holds up to the torque at which it slides, that of its brake."""

from typing import Literal, NamedTuple

from layflat.jit import law
from layflat.physics.friction.kind import FrictionKind, FrictionPart


class CoulombPart(FrictionPart):
    """Friction that is the brake's torque at rest and at any speed."""

    kind: Literal["coulomb"] = "coulomb"


class Coulomb(NamedTuple):
    """Nothing but the brake's torque."""


def parameters(described: CoulombPart) -> Coulomb:  # noqa: ARG001  (as of all kinds)
    """Return what stands for any Coulomb friction."""
    return Coulomb()


@law
def brake_alone(friction, brake, speed, pull):  # noqa: ARG001  (as of all kinds)
    """Torque at which the shaft slips: that of the brake, N m."""
    return brake


KIND = FrictionKind(
    name="coulomb",
    description=CoulombPart,
    parameters=parameters,
    parameter_types=(Coulomb,),
    level=brake_alone,
    constant=True,
    plain=Coulomb(),
)
