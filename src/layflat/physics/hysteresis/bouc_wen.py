"""Losses inside hose and strap: Bouc and Wen's law, a curve without corners whose small loops are not Masing's.

| symbol | meaning | unit |
|---|---|---|
| f | torque of the losses, without that of the spring beside them | N m |
| s, c | torque of that spring, its stiffness | N m, N m/rad |
| k | its slope where it carries nothing | N m/rad |
| Y | the torque that it approaches, Y = Y_0 + Y_1 p_g | N m |
| beta | share of the law that depends on the way of the motion; the rest, gamma = 1 - beta, does not | 1 |
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
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart, over_pressure

TINY = 1e-30  # N m: a hose without losses carries nothing of nothing


class BoucWen(NamedTuple):
    """Parameters, in the order of the table; of the unloading the factor beta - gamma."""

    stiffness: float
    base: float
    slope: float
    unloading: float
    exponent: float
    spring: float


class Torques(NamedTuple):
    """Torque of the losses, and of the spring beside them, N m."""

    torque: float
    spring: float


class BoucWenPart(LossesPart):
    """A smooth curve: how stiff it begins, how it bends, and how it comes back."""

    kind: Literal["bouc-wen"]
    deflection: u.PositiveAngle = Field(
        description="turn after which the whole loss would be reached at the curve's first slope, at reference pressure"
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
    """A curve that approaches `limit` (N m) at the reference pressure."""
    base, slope = over_pressure(described, limit)
    stiffness = limit / described.deflection
    unloading, spring = 2.0 * described.beta - 1.0, described.hardening * stiffness
    return BoucWen(stiffness, base, slope, unloading, described.exponent, spring)


@law
def _bend(n, z):
    return z * ((2.0 - n) + (n - 1.0) * z)


@law
def _steepness(n, z):
    return (2.0 - n) + 2.0 * (n - 1.0) * z


@law
def turned(loss, state, turn, p_g, h):  # noqa: ARG001
    """Torques after a turn at gauge pressure p_g, however long it took.

    A turn back first brings the torque to zero, and what is left of it builds it up the other way; each part is one
    linearly implicit step, of second order, that never makes energy.
    """
    k, n = loss.stiffness, loss.exponent
    Y = max(loss.base + loss.slope * max(p_g, 0.0), TINY)
    way = select(turn < 0.0, -1.0, 1.0)
    x, m = abs(turn), min(max(way * state.torque, -Y), Y)
    against = max(-m, 0.0)
    z = against / Y
    rate = k * (1.0 + loss.unloading * _bend(n, z))
    braked = 0.5 * k / Y * loss.unloading * _steepness(n, z)
    # As far as the torque is zero; where the turn ends before that, as far as it goes.
    back = min(x, select(against > 0.0, against / max(rate - braked * against, TINY), 0.0))
    left = against - back * rate / (1.0 + braked * back)
    along = max(m, 0.0)
    z = along / Y
    on = x - back
    gained = on * k * (1.0 - _bend(n, z)) / (1.0 + on * 0.5 * k / Y * _steepness(n, z))
    return Torques(way * min(along + gained - max(left, 0.0), Y), state.spring + loss.spring * turn)


@law
def torques(loss, state):  # noqa: ARG001
    """Both torques, N m."""
    return state.torque, state.spring


@law
def relaxed(loss):
    """A hose that carries nothing."""
    nothing = in_lanes(0.0, loss.stiffness)
    return Torques(nothing, nothing)


@law
def stored_energy(loss, state):
    """Energy of both springs, J."""
    inside = state.torque * state.torque / loss.stiffness if loss.stiffness > 0.0 else 0.0
    return 0.5 * (inside + (state.spring * state.spring / loss.spring if loss.spring > 0.0 else 0.0))


@law
def loaded(loss, p_g, share):
    """A share of what it approaches, the spring at rest."""
    carried = share * (loss.base + loss.slope * max(p_g, 0.0))
    return Torques(carried, 0.0 * carried)


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
