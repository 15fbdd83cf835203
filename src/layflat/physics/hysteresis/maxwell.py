"""Losses that relax: Maxwell elements in parallel, each a spring in series with a dashpot.

| symbol | meaning | unit |
|---|---|---|
| f | torque of an element | N m |
| k | its stiffness | N m/rad |
| tau | time in which it relaxes, tau = tau_0 + tau_1 p_g: pressure presses the layers together | s |
| z | step over tau | 1 |

df/dt = k v - f / tau (Wiechert's model, key ferry1980). A fast motion meets a spring, a slow one nothing; in between
work is lost. A step is the trapezoidal rule: of second order, and work less stored energy is (f_0 + f_1)^2 z/4k.
"""

from collections.abc import Sequence
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from layflat.description import units as u
from layflat.jit import law
from layflat.lanes import each, select
from layflat.physics.hysteresis import elasto_slip
from layflat.physics.hysteresis.elasto_slip import Elements
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart, over_pressure

TINY = 1e-12  # s: a time that is zero


class Maxwell(NamedTuple):
    """Of each element: stiffness, and the two parts of its relaxation time."""

    stiffness: tuple[float, ...]
    base: tuple[float, ...]
    slope: tuple[float, ...]


class MaxwellPart(LossesPart):
    """Elements that relax."""

    kind: Literal["maxwell"]
    deflection: u.PositiveAngle = Field(
        description="turn that, made at once, gives each element its weight of the loss"
    )
    times: Annotated[tuple[u.Time, ...], Field(min_length=1)] = Field(
        description="in which each element relaxes, at reference pressure"
    )
    weights: Annotated[tuple[u.Share, ...], Field(min_length=1)] = Field(
        description="torque of each element after that turn over the loss in a slow motion"
    )

    @model_validator(mode="after")
    def _pairs(self) -> Self:
        if len(self.weights) != len(self.times):
            raise ValueError("weights must be as many as times")
        return self


def elements(
    described: LossesPart, deflection: float, times: Sequence[float], weights: Sequence[float], limit: float
) -> Maxwell:
    """Elements that carry `weights` of `limit` (N m) after a sudden turn by `deflection` (rad), and relax (s)."""
    base, slope = zip(*(over_pressure(described, time) for time in times), strict=True)
    return Maxwell(tuple(weight * limit / deflection for weight in weights), base, slope)


def parameters(described: MaxwellPart, limit: float) -> Maxwell:
    """Elements beside a loss of `limit` (N m) at the reference pressure."""
    return elements(described, described.deflection, described.times, described.weights, limit)


@law
def _relaxing(f, k, tau_0, tau_1, turn, p_g, h):
    z = h / max(tau_0 + tau_1 * p_g, TINY)
    # The rule would swing about the answer beyond 2, where a dashpot is all that is left.
    per = 1.0 / (1.0 + 0.5 * z)
    kept = select(z < 2.0, (1.0 - 0.5 * z) * per, 0.0)
    return kept * f + select(z < 2.0, per, 1.0 / max(z, 1.0)) * (k * turn)


@law
def turned(loss, state, turn, p_g, h):
    """Elements after a turn in h seconds."""
    return Elements(each(_relaxing, state.torque, loss.stiffness, loss.base, loss.slope, turn, max(p_g, 0.0), h))


@law
def _none(k, share):
    return 0.0 * (share * k)


@law
def loaded(loss, p_g, share):  # noqa: ARG001
    """Elements that have relaxed: whatever they carried, they carry it no longer."""
    return Elements(each(_none, loss.stiffness, share))


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
