"""Kind of valve: laws from a driver's command to the conductances of a joint's two paths."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import nan
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from layflat.description import Part, ordered
from layflat.description import units as u
from layflat.errors import KindError
from layflat.jit import law
from layflat.kind_checks import (
    MisfitError,
    check_alike,
    check_items,
    check_nested,
    check_number,
    naming_law,
    tolerating_arithmetic,
)
from layflat.kinds import REQUIRED_ENTRY, Kind, KindPart
from layflat.lanes import select

Law = Callable[..., Any]

TRIAL_OPENINGS = (0.0, 1.0, -1.0, 0.3)  # openings with which a user's laws are tried

COMMON_FIELDS = (
    "conductance",
    "leakage",
    "critical_ratio",
    "laminar_slope",
    "centre_voltage",
    "volts_to_full",
    "delay",
)
"""Fields that the parameters of every valve have, for the laws that all kinds share."""


class DitherPart(Part):
    """Description of the dither: an oscillation that the driver adds to keep the spool moving."""

    amplitude: u.Share = Field(description="fraction of full opening")
    frequency: u.ValveFrequency
    min: u.Share = Field(
        default=0.0, description="lowest fraction of it that a controller can command; 1: the dither is constant"
    )


class ValvePart(KindPart):
    """Description of a valve and its driver, one a joint: fields that all kinds share."""

    conductance: u.ValveConductance = Field(description="ISO 6358 sonic conductance of a fully open path")
    critical_ratio: Annotated[u.Share, Field(lt=0.99)] = Field(description="ISO 6358 critical pressure ratio")
    leakage: u.ConductanceOrZero = Field(description="sonic conductance of a closed path")
    centre_voltage: u.Voltage
    volts_to_full: u.FullVoltage = Field(description="from the centre to full opening")
    delay: u.TimeOrZero = Field(default=0.0, description="from the command to the driver, at most three control cycles")

    _closes = ordered("leakage", "conductance", "leakage must be smaller than conductance")

    @property
    def dithered(self) -> DitherPart | None:
        """Dither that the driver adds; None for a valve without."""
        return None

    @property
    def wave_frequency(self) -> float | None:
        """Frequency of the driver's own wave (dither, carrier), Hz; None without a wave."""
        frequency: float | None = getattr(self, "frequency", None)
        return frequency

    @property
    def min_dither(self) -> float:
        """Fraction of the dither that can't be switched off; 1 for a valve without dither."""
        return 1.0

    @property
    def covered(self) -> float:
        """Fraction of the stroke in which it stays closed although it moves (overlap)."""
        return 0.0


class NoWave(NamedTuple):
    """Wave of a driver without dither or carrier."""

    phase: float


@law
def no_wave(valve, t, h):  # noqa: ARG001
    """Return the wave of a driver that makes none."""
    return NoWave(0.0)


@law
def same_wave(valve, wave):  # noqa: ARG001
    """Return the wave unchanged: the next step of a driver that makes none."""
    return wave


@law
def same_wave_at_any_fraction(valve, wave, share):  # noqa: ARG001
    """Return the wave unchanged, whatever the fraction: of a driver whose wave is no dither."""
    return wave


def refuse_seizure(valve: Any, *_: Any) -> Any:
    """Raise KindError: the kind of valve does not model a seized valve."""
    raise KindError(f"a {type(valve).__name__} can't be seized", right="give its kind of valve `seized` and `held_at`")


@dataclass(frozen=True, kw_only=True)
class MeanValve:
    """Laws of a valve averaged over the wave of its driver, for models that step in milliseconds.

    They are those of `ValveKind`; the wave is the fraction of the driver's that is present.
    """

    averaged: Callable[[Any], Any]  # from the parameters of the valve to the averaged ones
    parameter_type: type  # of these
    at_rest: Law
    move: Law
    opening: Law
    start_wave: Law
    turn_wave: Law = same_wave
    weaken_wave: Law = same_wave_at_any_fraction
    seized: Law = refuse_seizure
    held_at: Law = refuse_seizure


@dataclass(frozen=True, kw_only=True)
class ValveKind(Kind):
    """Kind of valve.

    `parameters(described)` yields a named tuple with at least the fields of `COMMON_FIELDS`, in SI units.
    """

    LAWS = ("at_rest", "move", "opening", "start_wave", "turn_wave")

    at_rest: Law = REQUIRED_ENTRY
    """`at_rest(valve)` yields the state of a valve that was never driven, a named tuple of floats."""
    move: Law = REQUIRED_ENTRY
    """`move(valve, state, command, wave, h)` yields the state after a step of h seconds at a commanded opening (-1 to
    1), and the mean conductances in it, m3/(s Pa), of the path that fills hose A and vents hose B and of the
    reverse."""
    opening: Law = REQUIRED_ENTRY  # `opening(valve, state)` yields the opening towards filling hose A, -1 to 1
    start_wave: Law = no_wave
    """`start_wave(valve, t, h)` yields the driver's own wave (dither, carrier) in the step that begins at t, a named
    tuple of floats; default: no wave."""
    turn_wave: Law = same_wave  # `turn_wave(valve, wave)` yields the same in the next step
    weaken_wave: Law = (
        same_wave_at_any_fraction  # `weaken_wave(valve, wave, share)` yields it with a fraction of the dither
    )
    seized: Law = refuse_seizure  # `seized(valve)`, not a law, yields parameters of a valve that does not move
    held_at: Law = refuse_seizure
    """`held_at(valve, opening)`, not a law, yields the state of a valve at rest at an opening."""
    mean: MeanValve | None = None  # the averaged valve; None where no such law is known

    def __post_init__(self) -> None:
        """Raise KindError if parameters lack one of `COMMON_FIELDS`."""
        super().__post_init__()
        for cls in self.parameter_types:
            lacking = [name for name in COMMON_FIELDS if name not in getattr(cls, "_fields", ())]
            if lacking:
                raise KindError(f"{cls.__name__} lacks {', '.join(lacking)}", where=f"kind {self.name!r} of valve")

    def guarded(self) -> "ValveKind":
        """Return the kind with conductances that become nan where they would be negative."""
        return replace(self, move=_with_valid_conductances(self.move))

    def try_laws(self, parameters: Any, *_: Any) -> None:
        """Call the laws of a valve at `TRIAL_OPENINGS`; raise KindError if a result has a wrong shape or value."""
        thing, h = f"valve {self.name!r}", 5e-4
        with tolerating_arithmetic(self.move):
            with naming_law(thing, "at_rest", self.at_rest):
                state = self.at_rest(parameters)
                check_nested(state, "the state")
            with naming_law(thing, "start_wave", self.start_wave):
                wave = self.start_wave(parameters, 0.0, h)
                check_nested(wave, "the wave")
            with naming_law(thing, "turn_wave", self.turn_wave):
                check_alike(self.turn_wave(parameters, wave), wave, "the wave")
            with naming_law(thing, "weaken_wave", self.weaken_wave):
                check_alike(self.weaken_wave(parameters, wave, 0.5), wave, "the wave")
            for command in TRIAL_OPENINGS:
                with naming_law(thing, "move", self.move):
                    moved = self.move(parameters, state, command, wave, h)
                    check_items(moved, 3, "the tuple of state and two conductances")
                    check_alike(moved[0], state, "the state")
                    for conductance in moved[1:]:
                        check_number(conductance, f"a conductance at an opening of {command:g}")
                        if conductance < 0.0:
                            raise MisfitError(f"a conductance at an opening of {command:g} is negative")
                state = moved[0]
                with naming_law(thing, "opening", self.opening):
                    check_number(self.opening(parameters, state), "the opening")

    def laws_by_parameter_type(self) -> Mapping[type, Any]:
        """Return the objects with the compiled laws, by type of the laws' parameters; the averaged valve's as well."""
        entries = super().laws_by_parameter_type()
        return entries if self.mean is None else {**entries, self.mean.parameter_type: self.mean}


def _with_valid_conductances(move_of: Law) -> Law:
    """Return the law of a valve's motion, with NaN in place of negative conductances."""

    @law
    def move(valve, state, command, wave, h):
        after, filling, venting = move_of(valve, state, command, wave, h)
        return after, select(filling < 0.0, nan, filling), select(venting < 0.0, nan, venting)

    return move
