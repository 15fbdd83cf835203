"""Coulomb friction: the joint slips at the torque of its brake, at rest and at any speed."""

from typing import Literal, NamedTuple

from layflat.jit import law
from layflat.physics.friction.kind import FrictionKind, FrictionPart


class CoulombPart(FrictionPart):
    """Friction that is the brake's torque at rest and at any speed."""

    kind: Literal["coulomb"] = "coulomb"


class Coulomb(NamedTuple):
    """Parameters of Coulomb friction: none, as the brake's torque is a signal."""


def parameters(described: CoulombPart) -> Coulomb:  # noqa: ARG001  (signature of all kinds)
    """Return the parameters of Coulomb friction."""
    return Coulomb()


@law
def brake_alone(friction, brake, speed, pull):  # noqa: ARG001  (signature of all kinds)
    """Return the torque at which the shaft slips: that of the brake, N m."""
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
