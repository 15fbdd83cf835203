"""Losses inside hose and strap: elasto-slip elements in parallel, which remember where the motion turned.

| symbol | meaning | unit |
|---|---|---|
| f | torque of an element | N m |
| k | its stiffness | N m/rad |
| Y | the torque at which it slips, Y = Y_0 + Y_1 p_g | N m |
| p_g | gauge pressure in the hose | Pa |

An element is a spring in series with a Coulomb slider (Prandtl-Ishlinskii model, Visintin 1994, key visintin1994). For
a motion much smaller than Y/k it is a spring and loses nothing: the reason why such hysteresis damps little.
"""

from typing import Literal, NamedTuple, Self

from pydantic import Field, model_validator

from layflat.description import units as u
from layflat.jit import law
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart


class ElastoSlip(NamedTuple):
    """Three elements: stiffness, slip torque without pressure and slip torque per gauge pressure of each."""

    stiffness_1: float
    stiffness_2: float
    stiffness_3: float
    base_1: float
    base_2: float
    base_3: float
    slope_1: float
    slope_2: float
    slope_3: float


class Elements(NamedTuple):
    """Torques of the elements, N m."""

    f_1: float
    f_2: float
    f_3: float


class ElastoSlipPart(LossesPart):
    """How the losses of hose and strap depend on pressure and on the size of the motion."""

    kind: Literal["elasto-slip"] = "elasto-slip"
    deflections: tuple[u.PositiveAngle, u.PositiveAngle, u.PositiveAngle] = Field(
        description="turn after which each of three elements slips, at reference pressure"
    )
    weights: tuple[u.Share, u.Share, u.Share] = Field(description="share of each element in the loss")

    @model_validator(mode="after")
    def _adds_up(self) -> Self:
        if abs(sum(self.weights) - 1.0) > 1e-9:
            raise ValueError("weights must add up to 1, for example [0.4, 0.3, 0.3]")
        return self


def parameters(described: ElastoSlipPart, limit: float) -> ElastoSlip:
    """Elements that slip at `limit` (N m) in all at the reference pressure."""
    limits = [weight * limit for weight in described.weights]
    free, at = described.pressure_free, described.reference_pressure_gauge
    stiffness = [y / d for y, d in zip(limits, described.deflections, strict=True)]
    return ElastoSlip(*stiffness, *(free * y for y in limits), *((1.0 - free) * y / at for y in limits))


@law
def slip(f, k, Y, turn):
    """Torque of an element after the joint has turned by `turn` rad."""
    return min(max(f + k * turn, -Y), Y)


@law
def relaxed(loss):  # noqa: ARG001  (as of all kinds)
    """Elements that carry nothing."""
    return Elements(0.0, 0.0, 0.0)


@law
def slip_all(loss, state, turn, p_g, h):  # noqa: ARG001
    """Elements after a turn at gauge pressure p_g, however long it took."""
    p_g = max(p_g, 0.0)
    return Elements(
        slip(state.f_1, loss.stiffness_1, loss.base_1 + loss.slope_1 * p_g, turn),
        slip(state.f_2, loss.stiffness_2, loss.base_2 + loss.slope_2 * p_g, turn),
        slip(state.f_3, loss.stiffness_3, loss.base_3 + loss.slope_3 * p_g, turn),
    )


@law
def element_torques(loss, state):  # noqa: ARG001
    """Torques of the elements, N m."""
    return state.f_1, state.f_2, state.f_3


@law
def stored_energy(loss, state):
    """Energy in the springs of the elements, J; zero for an element without stiffness, which carries no torque."""
    e_1 = state.f_1 * state.f_1 / loss.stiffness_1 if loss.stiffness_1 > 0.0 else 0.0
    e_2 = state.f_2 * state.f_2 / loss.stiffness_2 if loss.stiffness_2 > 0.0 else 0.0
    e_3 = state.f_3 * state.f_3 / loss.stiffness_3 if loss.stiffness_3 > 0.0 else 0.0
    return 0.5 * (e_1 + e_2 + e_3)


@law
def loaded(loss, p_g, share):
    """Elements that all carry the same share of their limits."""
    p_g = max(p_g, 0.0)
    return Elements(
        share * (loss.base_1 + loss.slope_1 * p_g),
        share * (loss.base_2 + loss.slope_2 * p_g),
        share * (loss.base_3 + loss.slope_3 * p_g),
    )


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
