"""Creep of woven straps and hoses: torque that relaxes with the logarithm of time.

Under a load yarns slide into place for minutes; what a turn has built up falls by about the same amount in each decade
of time. Maxwell elements (`maxwell`) of equal weight, their times in geometric progression, do the same from the first
time to the last. Source: key ferry1980; of yarns key morton2008.
"""

from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from layflat.description import ordered
from layflat.description import units as u
from layflat.physics.hysteresis import elasto_slip, maxwell
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart


class Creep(NamedTuple):
    """Parameters of the elements, as of `Maxwell`."""

    stiffness: tuple[float, ...]
    base: tuple[float, ...]
    slope: tuple[float, ...]


class CreepPart(LossesPart):
    """Elements that relax, spread over decades of time."""

    kind: Literal["creep"]
    deflection: u.PositiveAngle = Field(description="turn after which, made at once, `per_decade` holds")
    per_decade: u.Share = Field(description="torque that relaxes in a decade of time, over the loss of a slow motion")
    first: u.Time = Field(description="shortest time in which an element relaxes, at reference pressure")
    last: u.Time = Field(description="longest such time")
    elements: Annotated[int, Field(ge=2, le=32)] = Field(default=6, description="how many there are")

    _ordered = ordered("first", "last", "last must be greater than first, for example 10 ms and 100 s")


def parameters(described: CreepPart, limit: float) -> Creep:
    """Elements beside a loss of `limit` (N m) at the reference pressure."""
    ratio, n = described.last / described.first, described.elements
    times = [described.first * ratio**share for share in np.linspace(0.0, 1.0, n).tolist()]
    # The decades from first to last are n - 1 spaces between elements.
    weight = described.per_decade * np.log10(ratio) / (n - 1)
    return Creep(*maxwell.elements(described, described.deflection, times, [weight] * n, limit))


KIND = HysteresisKind(
    name="creep",
    description=CreepPart,
    parameters=parameters,
    parameter_types=(Creep,),
    at_rest=elasto_slip.relaxed,
    turned=maxwell.turned,
    torques=elasto_slip.element_torques,
    stored=elasto_slip.stored_energy,
    loaded=maxwell.loaded,
)
