"""Losses inside hose and strap: elasto-slip elements in parallel, with a memory of the reversals of the motion.

| symbol | meaning | unit |
|---|---|---|
| f | torque of an element | N m |
| k | its stiffness | N m/rad |
| Y | the torque at which it slips, Y = Y_0 + Y_1 p_g | N m |
| p_g | gauge pressure in the hose | Pa |

An element is a spring in series with a Coulomb slider (Prandtl-Ishlinskii model, Visintin 1994, key visintin1994). For
a motion much smaller than Y/k it is a spring and loses nothing: the reason why such hysteresis damps little. A branch
of a loop is the first way out at twice its size (Masing's rule), whatever the elements.

A spectrum is any number of elements from four numbers. They slip at deflections in geometric progression, from the
first slip to the last, and their weights are a power of these: weight ~ deflection^slope. With slope 0 each decade of
the motion's size takes an equal part of the loss; the more elements, the smoother the curve (iwan1966).
"""

from collections.abc import Sequence
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from layflat.description import ordered
from layflat.description import units as u
from layflat.jit import law
from layflat.lanes import each, in_lanes, total
from layflat.lazy import numpy as np
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart, split_by_pressure


class ElastoSlip(NamedTuple):
    """Parameters of each element: k (N m/rad), Y_0 (N m) and Y_1 (N m/Pa) of the module's table."""

    stiffness: tuple[float, ...]  # k, N m/rad
    base: tuple[float, ...]  # Y_0, N m
    slope: tuple[float, ...]  # Y_1, N m/Pa


class ElementTorques(NamedTuple):
    """Torques of the elements, N m."""

    torque: tuple[float, ...]  # f, N m


class ElastoSlipPart(LossesPart):
    """Description of elasto-slip elements, one by one."""

    kind: Literal["elasto-slip"] = "elasto-slip"
    deflections: Annotated[tuple[u.PositiveAngle, ...], Field(min_length=1)] = Field(
        description="rotation after which each of the elements slips, at reference pressure"
    )
    weights: Annotated[tuple[u.Share, ...], Field(min_length=1)] = Field(
        description="fraction of the loss that each element has"
    )

    @model_validator(mode="after")
    def _check_weights(self) -> Self:
        """Raise ValueError unless each deflection has a weight, and the weights add up to 1."""
        if len(self.weights) != len(self.deflections):
            raise ValueError(f"has {len(self.weights)} weights; give as many as deflections, {len(self.deflections)}")
        if abs(sum(self.weights) - 1.0) > 1e-9:
            raise ValueError("weights must add up to 1, for example [0.4, 0.3, 0.3]")
        return self


def elasto_slip_elements(
    described: LossesPart, deflections: Sequence[float], weights: Sequence[float], limit: float
) -> ElastoSlip:
    """Return the parameters of elements in parallel.

    Args:
        described: pressure dependence.
        deflections: rotations after which the elements slip at the reference pressure, rad.
        weights: fraction of each element in the limit torque.
        limit: torque that all elements carry together at the reference pressure, N m.
    """
    limits = [weight * limit for weight in weights]
    stiffness = tuple(y / d for y, d in zip(limits, deflections, strict=True))
    base, slope = zip(*(split_by_pressure(described, y) for y in limits), strict=True)
    return ElastoSlip(stiffness, base, slope)


def parameters(described: ElastoSlipPart, limit: float) -> ElastoSlip:
    """Return the parameters of elements that carry the limit torque (N m) together at the reference pressure."""
    return elasto_slip_elements(described, described.deflections, described.weights, limit)


@law
def slip_element(f, k, Y, turn):
    """Return the torque of an element after a rotation of the joint by `turn` rad."""
    return min(max(f + k * turn, -Y), Y)


@law
def carried_fraction(torque, limit):
    """Return the fraction of their limits at which elements carry a torque together, -1..1; 0 if the limit is 0."""
    return min(max(torque / limit, -1.0), 1.0) if limit > 0.0 else 0.0


@law
def _slip_at_pressure(f, k, Y_0, Y_1, turn, p_g):
    return slip_element(f, k, Y_0 + Y_1 * p_g, turn)


@law
def _loaded_torque(Y_0, Y_1, p_g, share):
    return share * (Y_0 + Y_1 * p_g)


@law
def _zero_torque(k):
    return in_lanes(0.0, k)


@law
def relaxed(loss):
    """Return the state of unloaded elements."""
    return ElementTorques(each(_zero_torque, loss.stiffness))


@law
def slip_all(loss, state, turn, p_g, h):  # noqa: ARG001
    """Return the state after a rotation `turn` (rad) at gauge pressure p_g (Pa); h is not used (rate-independent)."""
    return ElementTorques(
        each(_slip_at_pressure, state.torque, loss.stiffness, loss.base, loss.slope, turn, max(p_g, 0.0))
    )


@law
def element_torques(loss, state):  # noqa: ARG001
    """Return the torques of the elements, N m."""
    return state.torque


@law
def _energy(f, k):
    return 0.5 * (f * f / k) if k > 0.0 else 0.0


@law
def stored_energy(loss, state):
    """Return the energy in the springs of the elements, J; zero for an element without stiffness."""
    return total(each(_energy, state.torque, loss.stiffness))


@law
def loaded(loss, p_g, share):
    """Return the state in which all elements carry the same fraction `share` of their limits at p_g."""
    return ElementTorques(each(_loaded_torque, loss.base, loss.slope, max(p_g, 0.0), share))


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


class Spectrum(NamedTuple):
    """Parameters of the elements of a spectrum, as `ElastoSlip`."""

    stiffness: tuple[float, ...]
    base: tuple[float, ...]
    slope: tuple[float, ...]


class SpectrumPart(LossesPart):
    """Description of a spectrum of elasto-slip elements."""

    kind: Literal["elasto-slip-spectrum"]
    first: u.PositiveAngle = Field(description="rotation after which the first element slips, at reference pressure")
    last: u.PositiveAngle = Field(description="the same of the last element")
    elements: Annotated[int, Field(ge=2, le=32)] = Field(default=8, description="how many there are")
    slope: Annotated[float, Field(ge=-4.0, le=4.0)] = Field(
        default=0.0, description="power of the deflection to which each element's fraction of the loss is proportional"
    )

    _ordered = ordered("first", "last", "last must be greater than first, for example 0.3 deg and 12 deg")


def spectrum_elements(described: SpectrumPart) -> tuple[list[Any], list[Any]]:
    """Return deflections (rad) and weights of the elements, numbers, or arrays where the description has arrays."""
    ratio = described.last / described.first
    exponents = np.linspace(0.0, 1.0, described.elements).tolist()
    deflections = [described.first * ratio**exponent for exponent in exponents]
    # Relative to the first deflection, so that steep slopes stay in range.
    raw = [ratio ** (exponent * described.slope) for exponent in exponents]
    return deflections, [weight / sum(raw) for weight in raw]


def spectrum_parameters(described: SpectrumPart, limit: float) -> Spectrum:
    """Return the parameters of a spectrum that carries the limit torque (N m) at the reference pressure."""
    return Spectrum(*elasto_slip_elements(described, *spectrum_elements(described), limit))


SPECTRUM_KIND = HysteresisKind(
    name="elasto-slip-spectrum",
    description=SpectrumPart,
    parameters=spectrum_parameters,
    parameter_types=(Spectrum,),
    at_rest=relaxed,
    turned=slip_all,
    torques=element_torques,
    stored=stored_energy,
    loaded=loaded,
)
