"""Losses inside hose and strap: elasto-slip elements in parallel, which remember where the motion turned.

| symbol | meaning | unit |
|---|---|---|
| f | torque of an element | N m |
| k | its stiffness | N m/rad |
| Y | the torque at which it slips, Y = Y_0 + Y_1 p_g | N m |
| p_g | gauge pressure in the hose | Pa |

An element is a spring in series with a Coulomb slider (Prandtl-Ishlinskii model, Visintin 1994, key visintin1994). For
a motion much smaller than Y/k it is a spring and loses nothing: the reason why such hysteresis damps little. A branch
of a loop is the first way out at twice its size (Masing's rule), whatever the elements.
"""

from collections.abc import Sequence
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from layflat.description import units as u
from layflat.jit import law
from layflat.lanes import each, in_lanes, total
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart, over_pressure


class ElastoSlip(NamedTuple):
    """Parameters of each element: stiffness, slip torque without pressure, and slip torque per gauge pressure."""

    stiffness: tuple[float, ...]
    base: tuple[float, ...]
    slope: tuple[float, ...]


class Elements(NamedTuple):
    """Torques of the elements, N m."""

    torque: tuple[float, ...]


class ElastoSlipPart(LossesPart):
    """Losses of hose and strap by pressure and size of the motion."""

    kind: Literal["elasto-slip"] = "elasto-slip"
    deflections: Annotated[tuple[u.PositiveAngle, ...], Field(min_length=1)] = Field(
        description="turn after which each of the elements slips, at reference pressure"
    )
    weights: Annotated[tuple[u.Share, ...], Field(min_length=1)] = Field(
        description="share of each element in the loss"
    )

    @model_validator(mode="after")
    def _adds_up(self) -> Self:
        if len(self.weights) != len(self.deflections):
            raise ValueError("weights must be as many as deflections")
        if abs(sum(self.weights) - 1.0) > 1e-9:
            raise ValueError("weights must add up to 1, for example [0.4, 0.3, 0.3]")
        return self


def elements(described: LossesPart, deflections: Sequence[float], weights: Sequence[float], limit: float) -> ElastoSlip:
    """Elements that slip after `deflections` (rad) at their shares of `limit` (N m), both at the reference pressure."""
    limits = [weight * limit for weight in weights]
    stiffness = tuple(y / d for y, d in zip(limits, deflections, strict=True))
    base, slope = zip(*(over_pressure(described, y) for y in limits), strict=True)
    return ElastoSlip(stiffness, base, slope)


def parameters(described: ElastoSlipPart, limit: float) -> ElastoSlip:
    """Elements that slip at `limit` (N m) in all at the reference pressure."""
    return elements(described, described.deflections, described.weights, limit)


@law
def slip(f, k, Y, turn):
    """Torque of an element after the joint has turned by `turn` rad."""
    return min(max(f + k * turn, -Y), Y)


@law
def share_carried(wanted, limit):
    """Share of their limits that elements carry so that `wanted` is met, -1..1, where no log shows how they begin."""
    return min(max(wanted / limit, -1.0), 1.0) if limit > 0.0 else 0.0


@law
def _slipped(f, k, Y_0, Y_1, turn, p_g):
    return slip(f, k, Y_0 + Y_1 * p_g, turn)


@law
def _carrying(Y_0, Y_1, p_g, share):
    return share * (Y_0 + Y_1 * p_g)


@law
def _nothing(k):
    return in_lanes(0.0, k)


@law
def relaxed(loss):
    """Elements that carry nothing."""
    return Elements(each(_nothing, loss.stiffness))


@law
def slip_all(loss, state, turn, p_g, h):  # noqa: ARG001
    """Elements after a turn at gauge pressure p_g, however long it took."""
    return Elements(each(_slipped, state.torque, loss.stiffness, loss.base, loss.slope, turn, max(p_g, 0.0)))


@law
def element_torques(loss, state):  # noqa: ARG001
    """Torques of the elements, N m."""
    return state.torque


@law
def _energy(f, k):
    return 0.5 * (f * f / k) if k > 0.0 else 0.0


@law
def stored_energy(loss, state):
    """Energy in the springs of the elements, J; zero for an element without stiffness, which carries no torque."""
    return total(each(_energy, state.torque, loss.stiffness))


@law
def loaded(loss, p_g, share):
    """Elements that all carry the same share of their limits."""
    return Elements(each(_carrying, loss.base, loss.slope, max(p_g, 0.0), share))


KIND = HysteresisKind(
    name="elasto-slip",
    description=ElastoSlipPart,
    parameters=parameters,
    parameter_types=(ElastoSlip,),
    at_rest=relaxed,
    turned=slip_all,
    torques=element_torques,
    stored=stored_energy,
    loaded=loaded,
)
