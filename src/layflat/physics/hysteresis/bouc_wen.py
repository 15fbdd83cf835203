"""Losses inside hose and strap: Bouc and Wen's law, a curve without corners whose small loops are not Masing's.

| symbol | meaning | unit |
|---|---|---|
| f | torque of the losses, without that of the parallel spring | N m |
| s, c | torque of that spring, its stiffness | N m, N m/rad |
| k | slope of f where f = 0 | N m/rad |
| Y | limit of f, Y = Y_0 + Y_1 p_g | N m |
| beta | part of the law that depends on the direction of motion; gamma = 1 - beta does not | 1 |
| n | exponent, 1 to 2: how suddenly it yields | 1 |
| m | torque along the motion, f sign(turn) | N m |
| g | |m/Y|^n | 1 |

df/dq = k (1 - (beta sign(f v) + gamma) |f/Y|^n), by Bouc and Wen (key wen1976). It dissipates whatever the motion if
beta >= |gamma| (key ismail2009), here beta >= 1/2. Between 1 and 2 the power is a blend of both, (2 - n) |f/Y| +
(n - 1) (f/Y)^2. The energy stored is f^2 / 2k + s^2 / 2c. After a small cycle the torque does not come back to where
it began, unlike Masing's: a load that ripples about a mean creeps.
"""

from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from layflat.description import units as u
from layflat.jit import law
from layflat.lanes import in_lanes, select
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart, split_by_pressure

TORQUE_FLOOR = 1e-30  # lower limit of a divisor, N m: a hose without losses divides 0 by it


class BoucWen(NamedTuple):
    """Parameters of Bouc and Wen's law, in the order of the table; `unloading` is beta - gamma."""

    stiffness: float
    base: float
    slope: float
    unloading: float
    exponent: float
    spring: float


class BoucWenState(NamedTuple):
    """State: torque of the losses, and of the parallel spring, N m."""

    torque: float
    spring: float


class BoucWenPart(LossesPart):
    """Description of a smooth curve: initial stiffness, exponent and unloading."""

    kind: Literal["bouc-wen"]
    deflection: u.PositiveAngle = Field(
        description="rotation at which the initial slope of the curve reaches the whole loss, at reference pressure"
    )
    beta: Annotated[float, Field(ge=0.5, le=3.0)] = Field(
        default=0.5, description="beta / (beta + gamma): 0.5 comes back straight, more comes back steeper"
    )
    exponent: Annotated[float, Field(ge=1.0, le=2.0)] = Field(
        default=1.0, description="n: how suddenly the curve bends"
    )
    hardening: u.Share = Field(
        default=0.0, description="stiffness of a spring beside the losses, over the curve's first slope"
    )


def parameters(described: BoucWenPart, limit: float) -> BoucWen:
    """Return the parameters of a curve that approaches the limit torque (N m) at the reference pressure."""
    base, slope = split_by_pressure(described, limit)
    stiffness = limit / described.deflection
    unloading, spring = 2.0 * described.beta - 1.0, described.hardening * stiffness
    return BoucWen(stiffness, base, slope, unloading, described.exponent, spring)


@law
def _power(n, z):
    return z * ((2.0 - n) + (n - 1.0) * z)


@law
def _power_slope(n, z):
    return (2.0 - n) + 2.0 * (n - 1.0) * z


@law
def turned(loss, state, turn, p_g, h):  # noqa: ARG001
    """Return the state after a rotation `turn` (rad) at gauge pressure p_g (Pa); h is not used (rate-independent).

    A reversal first unloads the torque to zero, and the rest of the rotation loads it the other way; each part is one
    linearly implicit step, of second order, that never generates energy.
    """
    k, n = loss.stiffness, loss.exponent
    Y = max(loss.base + loss.slope * max(p_g, 0.0), TORQUE_FLOOR)
    sign = select(turn < 0.0, -1.0, 1.0)
    x, m = abs(turn), min(max(sign * state.torque, -Y), Y)
    against = max(-m, 0.0)
    z = against / Y
    rate = k * (1.0 + loss.unloading * _power(n, z))
    braked = 0.5 * k / Y * loss.unloading * _power_slope(n, z)
    # Rotation that unloads the torque to zero, or all of it where it ends before that.
    back = min(x, select(against > 0.0, against / max(rate - braked * against, TORQUE_FLOOR), 0.0))
    residual = against - back * rate / (1.0 + braked * back)
    along = max(m, 0.0)
    z = along / Y
    on = x - back
    increment = on * k * (1.0 - _power(n, z)) / (1.0 + on * 0.5 * k / Y * _power_slope(n, z))
    return BoucWenState(sign * min(along + increment - max(residual, 0.0), Y), state.spring + loss.spring * turn)


@law
def torques(loss, state):  # noqa: ARG001
    """Return the torques of the losses and of the parallel spring, N m."""
    return state.torque, state.spring


@law
def relaxed(loss):
    """Return the state without torque."""
    zero = in_lanes(0.0, loss.stiffness)
    return BoucWenState(zero, zero)


@law
def stored_energy(loss, state):
    """Return the energy of f in a spring of stiffness k and of the parallel spring, J; 0 for a stiffness of 0."""
    inside = state.torque * state.torque / loss.stiffness if loss.stiffness > 0.0 else 0.0
    return 0.5 * (inside + (state.spring * state.spring / loss.spring if loss.spring > 0.0 else 0.0))


@law
def loaded(loss, p_g, share):
    """Return the state with a fraction `share` of the limit torque at p_g, the spring unloaded."""
    carried = share * (loss.base + loss.slope * max(p_g, 0.0))
    return BoucWenState(carried, 0.0 * carried)


KIND = HysteresisKind(
    name="bouc-wen",
    description=BoucWenPart,
    parameters=parameters,
    parameter_types=(BoucWen,),
    at_rest=relaxed,
    turned=turned,
    torques=torques,
    stored=stored_energy,
    loaded=loaded,
)
