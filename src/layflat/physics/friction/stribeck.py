"""Friction that falls from a static to a kinetic level as a shaft begins to turn, and grows with the bearings' load.

| symbol | meaning | unit |
|---|---|---|
| F | torque at which the shaft slips | N m |
| F_b | that of the brake | N m |
| F_0 | drag of bearings and seals without load | N m |
| mu | torque of friction over the torques of both hoses | 1 |
| T | sum of the torques of both hoses, the load of the straps | N m |
| s | static over kinetic friction, less one | 1 |
| v, v_s | speed, Stribeck velocity | rad/s |

F = (F_b + F_0 + mu T) (1 + s/(1 + (v/v_s)^2)). That friction falls as sliding begins was measured by Stribeck (1902,
key stribeck1902); this shape of the fall is that of Hess and Soom (1990, key hess1990), one of those that
Armstrong-Helouvry et al. (1994, key armstrong1994) compare. An exponential has the same level at rest and far from it;
this one needs no exponential function.
"""

from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from layflat.description import units as u
from layflat.jit import law
from layflat.physics.friction.kind import FrictionKind, FrictionPart

StaticRatio = Annotated[float, Field(ge=1.0, le=10.0)]


class StribeckPart(FrictionPart):
    """Description of Stribeck friction: static and kinetic level, drag and load of the bearings."""

    kind: Literal["stribeck"]
    static_ratio: StaticRatio = Field(description="static over kinetic friction, 1 or more")
    velocity: u.PositiveSpeed = Field(description="at which half of the difference remains (Stribeck velocity)")
    drag: u.Torque = Field(
        default=0.0, description="kinetic friction of bearings and seals without load, whatever the brake's signal"
    )
    load_ratio: u.Share = Field(
        default=0.0,
        description="kinetic friction of the bearings over the torques of both hoses, added up: coefficient of friction"
        " x radius of the bearing / radius at which the strap pulls",
    )


class Stribeck(NamedTuple):
    """Parameters of Stribeck friction: s, 1/v_s^2, F_0 and mu of the module's table."""

    excess: float
    per_velocity_squared: float
    drag: float
    load_ratio: float


def parameters(described: StribeckPart) -> Stribeck:
    """Return the parameters of a description."""
    return Stribeck(
        described.static_ratio - 1.0,
        1.0 / (described.velocity * described.velocity),
        described.drag,
        described.load_ratio,
    )


@law
def falling_share(excess, per_velocity_squared, speed):
    """Return friction over kinetic friction: 1 + s at rest, 1 + s/2 at the Stribeck velocity, 1 far above."""
    return 1.0 + excess / (1.0 + speed * speed * per_velocity_squared)


@law
def falling_level(friction, brake, speed, pull):
    """Return the torque at which the shaft slips, N m."""
    kinetic = brake + friction.drag + friction.load_ratio * pull
    return kinetic * falling_share(friction.excess, friction.per_velocity_squared, speed)


KIND = FrictionKind(
    name="stribeck",
    description=StribeckPart,
    parameters=parameters,
    parameter_types=(Stribeck,),
    level=falling_level,
    plain=Stribeck(0.0, 0.0, 0.0, 0.0),
)
