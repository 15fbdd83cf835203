"""Losses inside hose and strap, of any kind, and several kinds in parallel, whose torques add up.

A new kind is one file and one line here; see docs/kinds.md. So hysteresis and creep, or Bouc and Wen's law beside a
spectrum, make one law. Each part has the pressure dependence of the whole unless it says otherwise; shares are given to
parts that are rate-independent each by itself.
"""

from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import Field, model_validator

from layflat.description import units as u
from layflat.jit import law
from layflat.kinds import AnyKindOf, KindTable
from layflat.physics.hysteresis import bouc_wen, elasto_slip, maxwell
from layflat.physics.hysteresis.kind import HysteresisKind, LossesPart

HYSTERESIS: KindTable[HysteresisKind] = KindTable(
    "hysteresis", elasto_slip.KIND, elasto_slip.SPECTRUM_KIND, bouc_wen.KIND, maxwell.KIND, maxwell.CREEP_KIND
)

at_rest = HYSTERESIS.law("at_rest")
turned = HYSTERESIS.law("turned")
torques = HYSTERESIS.law("torques")
stored = HYSTERESIS.law("stored")
loaded = HYSTERESIS.law("loaded")


PARALLEL_NAME = "parallel"


class Parallel(NamedTuple):
    """Parameters of two parallel kinds; of more, the second is a `Parallel` itself."""

    first: Any
    second: Any


class Both(NamedTuple):
    """States of two parallel kinds."""

    first: Any
    second: Any


class ParallelPart(LossesPart):
    """Description of several kinds of losses in parallel, by the user's names, and each one's fraction of the loss."""

    kind: Literal["parallel"]
    parts: Annotated[dict[str, Annotated[LossesPart, AnyKindOf(HYSTERESIS, but=PARALLEL_NAME)]], Field(min_length=2)]
    fractions: dict[str, u.Share] = Field(
        default={}, description="of parts whose loss is not the whole one that hose and strap were measured to have"
    )

    @model_validator(mode="before")
    @classmethod
    def _inherit_pressure_dependence(cls, table: Any) -> Any:
        """Return the table with the pressure dependence of the whole in every part that has none of its own."""
        if not (isinstance(table, dict) and isinstance(table.get("parts"), dict)):
            return table
        whole = {key: table[key] for key in ("reference_pressure_gauge", "pressure_free") if key in table}
        parts = {name: whole | part if isinstance(part, dict) else part for name, part in table["parts"].items()}
        return table | {"parts": parts}

    @model_validator(mode="after")
    def _check_fractions(self) -> Self:
        """Raise ValueError if a fraction is of no part, or a part has a damping time of its own."""
        unknown = [name for name in self.fractions if name not in self.parts]
        if unknown:
            raise ValueError(f"fractions: there is no part {unknown[0]!r}; use {', '.join(self.parts)}")
        if any(part.damping_time > 0.0 for part in self.parts.values()):
            raise ValueError("a part has a damping_time; give it to the whole")
        return self


def parallel_parameters(described: ParallelPart, limit: float) -> Parallel:
    """Return the parameters of all parts, each with its fraction of the limit torque (N m), nested from the last on."""
    parts = [
        HYSTERESIS.parameters(part, described.fractions.get(name, 1.0) * limit)
        for name, part in described.parts.items()
    ]
    nested = Parallel(*parts[-2:])
    for part in reversed(parts[:-2]):
        nested = Parallel(part, nested)
    return nested


@law
def both_at_rest(loss):
    """Return the states of all parts at rest."""
    return Both(at_rest(loss.first), at_rest(loss.second))


@law
def both_turned(loss, state, turn, p_g, h):
    """Return the states of all parts after a rotation."""
    return Both(turned(loss.first, state.first, turn, p_g, h), turned(loss.second, state.second, turn, p_g, h))


@law
def both_torques(loss, state):
    """Return the torques of all parts, N m."""
    return torques(loss.first, state.first) + torques(loss.second, state.second)


@law
def both_stored(loss, state):
    """Return the energy that all parts store, J."""
    return stored(loss.first, state.first) + stored(loss.second, state.second)


@law
def both_loaded(loss, p_g, share):
    """Return states in which all parts carry the same fraction of their limits; those that relax carry none."""
    return Both(loaded(loss.first, p_g, share), loaded(loss.second, p_g, share))


PARALLEL_KIND = HYSTERESIS.register(
    HysteresisKind(
        name=PARALLEL_NAME,
        description=ParallelPart,
        parameters=parallel_parameters,
        parameter_types=(Parallel,),
        at_rest=both_at_rest,
        turned=both_turned,
        torques=both_torques,
        stored=both_stored,
        loaded=both_loaded,
    )
)


__all__ = [
    "HYSTERESIS",
    "HysteresisKind",
    "LossesPart",
    "ParallelPart",
    "at_rest",
    "loaded",
    "stored",
    "torques",
    "turned",
]
