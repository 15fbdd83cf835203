"""Losses of several kinds in parallel: their torques add up.

So hysteresis and creep, or Bouc and Wen's law beside a spectrum, make one law. Each part has the pressure dependence of
the whole unless it says otherwise; shares are given to parts that are rate-independent each by itself.
"""

from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from layflat.description import units as u
from layflat.jit import law
from layflat.kinds import AnyOf
from layflat.physics.hysteresis import table
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart

NAME = "parallel"


class Parallel(NamedTuple):
    """Parameters of two kinds; of more, the second is a `Parallel` itself."""

    first: Any
    second: Any


class Both(NamedTuple):
    """States of the two."""

    first: Any
    second: Any


class ParallelPart(LossesPart):
    """Several kinds of losses by names of the user's own, and each one's share of the loss."""

    kind: Literal["parallel"]
    parts: Annotated[dict[str, Annotated[LossesPart, AnyOf(table.HYSTERESIS, but=NAME)]], Field(min_length=2)]
    shares: dict[str, u.Share] = Field(
        default={}, description="of parts whose loss is not the whole one that hose and strap were measured to have"
    )

    @model_validator(mode="before")
    @classmethod
    def _as_the_whole(cls, given: Any) -> Any:
        """Give every part what the whole says of pressure, where it says nothing itself."""
        if not (isinstance(given, dict) and isinstance(given.get("parts"), dict)):
            return given
        whole = {key: given[key] for key in ("reference_pressure_gauge", "pressure_free") if key in given}
        parts = {name: whole | part if isinstance(part, dict) else part for name, part in given["parts"].items()}
        return given | {"parts": parts}

    @model_validator(mode="after")
    def _shares_of_parts(self) -> Self:
        unknown = [name for name in self.shares if name not in self.parts]
        if unknown:
            raise ValueError(f"shares: there is no part {unknown[0]!r}; use {', '.join(self.parts)}")
        if any(part.damping_time > 0.0 for part in self.parts.values()):
            raise ValueError("a part has a damping_time; give it to the whole")
        return self


def parameters(described: ParallelPart, limit: float) -> Parallel:
    """Parameters of all parts, each with its share of `limit` (N m)."""
    parts = [
        table.HYSTERESIS.parameters(part, described.shares.get(name, 1.0) * limit)
        for name, part in described.parts.items()
    ]
    found = Parallel(*parts[-2:])
    for one in reversed(parts[:-2]):
        found = Parallel(one, found)
    return found


@law
def at_rest(loss):
    """All at rest."""
    return Both(table.at_rest(loss.first), table.at_rest(loss.second))


@law
def turned(loss, state, turn, p_g, h):
    """All turned."""
    return Both(
        table.turned(loss.first, state.first, turn, p_g, h), table.turned(loss.second, state.second, turn, p_g, h)
    )


@law
def torques(loss, state):
    """Torques of all, N m."""
    return table.torques(loss.first, state.first) + table.torques(loss.second, state.second)


@law
def stored(loss, state):
    """Energy that all store, J."""
    return table.stored(loss.first, state.first) + table.stored(loss.second, state.second)


@law
def loaded(loss, p_g, share):
    """All with the same share of what they can carry."""
    return Both(table.loaded(loss.first, p_g, share), table.loaded(loss.second, p_g, share))


KIND = table.HYSTERESIS.register(
    HysteresisKind(
        name=NAME,
        description=ParallelPart,
        parameters=parameters,
        parameter_types=(Parallel,),
        at_rest=at_rest,
        turned=turned,
        torques=torques,
        stored=stored,
        loaded=loaded,
    )
)
