"""Losses that relax: Maxwell elements in parallel, each a spring in series with a dashpot.

| symbol | meaning | unit |
|---|---|---|
| f | torque of an element | N m |
| k | its stiffness | N m/rad |
| tau | relaxation time, tau = tau_0 + tau_1 p_g: pressure presses the layers together | s |
| z | step over tau | 1 |

df/dt = k v - f / tau (Wiechert's model, key ferry1980). A fast motion meets a spring, a slow one no torque; in between
work is dissipated. A step is the trapezoidal rule: of second order, and work less stored energy is (f_0 + f_1)^2 z/4k.

Creep of woven straps and hoses is torque that relaxes with the logarithm of time: under a load yarns slide into place
for minutes, and the torque of a rotation falls by about the same amount in each decade of time. Elements of equal
weight, their times in geometric progression, do the same from the first time to the last (of yarns key morton2008).
"""

from collections.abc import Sequence
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from layflat.description import ordered
from layflat.description import units as u
from layflat.jit import law
from layflat.lanes import each, select
from layflat.lazy import numpy as np
from layflat.physics.hysteresis import elasto_slip
from layflat.physics.hysteresis.elasto_slip import ElementTorques
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart, split_by_pressure

TIME_FLOOR = 1e-12  # lower limit of a relaxation time, s


class Maxwell(NamedTuple):
    """Parameters of each element: k (N m/rad), tau_0 (s) and tau_1 (s/Pa) of the module's table."""

    stiffness: tuple[float, ...]  # k, N m/rad
    base: tuple[float, ...]  # tau_0, s
    slope: tuple[float, ...]  # tau_1, s/Pa


class MaxwellPart(LossesPart):
    """Description of Maxwell elements, one by one."""

    kind: Literal["maxwell"]
    deflection: u.PositiveAngle = Field(
        description="sudden rotation after which each element has its weight of the loss"
    )
    times: Annotated[tuple[u.Time, ...], Field(min_length=1)] = Field(
        description="in which each element relaxes, at reference pressure"
    )
    weights: Annotated[tuple[u.Share, ...], Field(min_length=1)] = Field(
        description="torque of each element after that rotation over the loss in a slow motion"
    )

    @model_validator(mode="after")
    def _check_counts(self) -> Self:
        """Raise ValueError unless each relaxation time has a weight."""
        if len(self.weights) != len(self.times):
            raise ValueError(f"has {len(self.weights)} weights; give as many as times, {len(self.times)}")
        return self


def maxwell_elements(
    described: LossesPart, deflection: float, times: Sequence[float], weights: Sequence[float], limit: float
) -> Maxwell:
    """Return the parameters of elements in parallel.

    Args:
        described: pressure dependence, of the relaxation times.
        deflection: sudden rotation after which the elements carry their weights, rad.
        times: relaxation times at the reference pressure, s.
        weights: torque of each element after that rotation over the limit torque.
        limit: torque of the losses in a slow motion at the reference pressure, N m.
    """
    base, slope = zip(*(split_by_pressure(described, time) for time in times), strict=True)
    return Maxwell(tuple(weight * limit / deflection for weight in weights), base, slope)


def parameters(described: MaxwellPart, limit: float) -> Maxwell:
    """Return the parameters of elements parallel to losses with the limit torque (N m) at the reference pressure."""
    return maxwell_elements(described, described.deflection, described.times, described.weights, limit)


@law
def _relax_element(f, k, tau_0, tau_1, turn, p_g, h):
    """Return the torque of an element (N m) after a step of h seconds with a rotation `turn` (rad)."""
    z = h / max(tau_0 + tau_1 * p_g, TIME_FLOOR)
    # The rule would oscillate beyond z = 2, where the element is a dashpot.
    per = 1.0 / (1.0 + 0.5 * z)
    kept = select(z < 2.0, (1.0 - 0.5 * z) * per, 0.0)
    return kept * f + select(z < 2.0, per, 1.0 / max(z, 1.0)) * (k * turn)


@law
def turned(loss, state, turn, p_g, h):
    """Return the state after a rotation `turn` (rad) in h seconds at gauge pressure p_g (Pa)."""
    return ElementTorques(
        each(_relax_element, state.torque, loss.stiffness, loss.base, loss.slope, turn, max(p_g, 0.0), h)
    )


@law
def _relaxed_torque(k, share):
    return 0.0 * (share * k)


@law
def loaded(loss, p_g, share):  # noqa: ARG001
    """Return the state of relaxed elements: no torque, whatever the fraction."""
    return ElementTorques(each(_relaxed_torque, loss.stiffness, share))


KIND = HysteresisKind(
    name="maxwell",
    description=MaxwellPart,
    parameters=parameters,
    parameter_types=(Maxwell,),
    at_rest=elasto_slip.relaxed,
    turned=turned,
    torques=elasto_slip.element_torques,
    stored=elasto_slip.stored_energy,
    loaded=loaded,
)


class Creep(NamedTuple):
    """Parameters of the elements of creep, as `Maxwell`."""

    stiffness: tuple[float, ...]
    base: tuple[float, ...]
    slope: tuple[float, ...]


class CreepPart(LossesPart):
    """Description of creep: Maxwell elements with relaxation times over decades."""

    kind: Literal["creep"]
    deflection: u.PositiveAngle = Field(description="sudden rotation after which `per_decade` holds")
    per_decade: u.Share = Field(description="torque that relaxes in a decade of time, over the loss of a slow motion")
    first: u.Time = Field(description="shortest time in which an element relaxes, at reference pressure")
    last: u.Time = Field(description="longest such time")
    elements: Annotated[int, Field(ge=2, le=32)] = Field(default=6, description="how many there are")

    _ordered = ordered("first", "last", "last must be greater than first, for example 10 ms and 100 s")


def creep_parameters(described: CreepPart, limit: float) -> Creep:
    """Return the parameters of elements parallel to losses with the limit torque (N m) at the reference pressure."""
    ratio, n = described.last / described.first, described.elements
    times = [described.first * ratio**exponent for exponent in np.linspace(0.0, 1.0, n).tolist()]
    # The decades from first to last are n - 1 spaces between elements.
    weight = described.per_decade * np.log10(ratio) / (n - 1)
    return Creep(*maxwell_elements(described, described.deflection, times, [weight] * n, limit))


CREEP_KIND = HysteresisKind(
    name="creep",
    description=CreepPart,
    parameters=creep_parameters,
    parameter_types=(Creep,),
    at_rest=elasto_slip.relaxed,
    turned=turned,
    torques=elasto_slip.element_torques,
    stored=elasto_slip.stored_energy,
    loaded=loaded,
)
