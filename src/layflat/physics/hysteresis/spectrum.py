"""Any number of elasto-slip elements from four numbers: a spectrum between the first slip and the last.

The elements slip at deflections in geometric progression, and their weights are a power of these: weight ~
deflection^slope. With slope 0 each decade of the motion's size takes an equal part of the loss; the more elements, the
smoother the curve. The law is that of `elasto_slip` (key visintin1994; spectra: iwan1966).
"""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from layflat.description import ordered
from layflat.description import units as u
from layflat.physics.hysteresis import elasto_slip
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart


class Spectrum(NamedTuple):
    """Parameters of the elements, as of `ElastoSlip`."""

    stiffness: tuple[float, ...]
    base: tuple[float, ...]
    slope: tuple[float, ...]


class SpectrumPart(LossesPart):
    """A spectrum of elasto-slip elements."""

    kind: Literal["elasto-slip-spectrum"]
    first: u.PositiveAngle = Field(description="turn after which the first element slips, at reference pressure")
    last: u.PositiveAngle = Field(description="the same of the last element")
    elements: Annotated[int, Field(ge=2, le=32)] = Field(default=8, description="how many there are")
    slope: Annotated[float, Field(ge=-4.0, le=4.0)] = Field(
        default=0.0, description="power of the deflection that each element's share of the loss is proportional to"
    )

    _ordered = ordered("first", "last", "last must be greater than first, for example 0.3 deg and 12 deg")


def elements(described: SpectrumPart) -> tuple[list[Any], list[Any]]:
    """Deflections (rad) and weights of the elements; each is a number, or an array where the description has arrays."""
    ratio = described.last / described.first
    shares = np.linspace(0.0, 1.0, described.elements).tolist()
    deflections = [described.first * ratio**share for share in shares]
    # Relative to the first deflection, so that steep slopes stay in range.
    raw = [ratio ** (share * described.slope) for share in shares]
    return deflections, [one / sum(raw) for one in raw]


def parameters(described: SpectrumPart, limit: float) -> Spectrum:
    """Elements that slip at `limit` (N m) in all at the reference pressure."""
    return Spectrum(*elasto_slip.elements(described, *elements(described), limit))


KIND = HysteresisKind(
    name="elasto-slip-spectrum",
    description=SpectrumPart,
    parameters=parameters,
    parameter_types=(Spectrum,),
    at_rest=elasto_slip.relaxed,
    turned=elasto_slip.slip_all,
    torques=elasto_slip.element_torques,
    stored=elasto_slip.stored_energy,
    loaded=elasto_slip.loaded,
)
