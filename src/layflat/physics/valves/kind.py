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
from layflat.kinds import REQUIRED, Kind, KindPart
from layflat.lanes import select

Law = Callable[..., Any]

TRIED = (0.0, 1.0, -1.0, 0.3)  # openings with which laws from outside are tried

COMMON = ("conductance", "leakage", "critical_ratio", "laminar_slope", "centre_voltage", "volts_to_full", "delay")
"""What the parameters of every valve hold, so that air flows and voltages act alike through all."""


class Dither(Part):
    """Oscillation that the driver adds to keep the spool moving."""

    amplitude: u.Share = Field(description="share of full opening")
    frequency: u.ValveFrequency
    least: u.Share = Field(
        default=0.0, description="share of it that the driver adds at any time; 1: nobody can stop it"
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
    def dithered(self) -> Dither | None:
        """The dither that its driver has to add; None for a valve without."""
        return None

    @property
    def wave_frequency(self) -> float | None:
        """Frequency of what its driver makes by itself, Hz; None of one that makes nothing."""
        frequency: float | None = getattr(self, "frequency", None)
        return frequency

    @property
    def least_dither(self) -> float:
        """Share of the dither that nobody can stop; 1 for a valve without."""
        return 1.0

    @property
    def covered(self) -> float:
        """Share of the stroke in which it stays closed although it moves."""
        return 0.0


class Still(NamedTuple):
    """The wave of a driver that makes none."""

    phase: float


@law
def no_wave(valve, t, h):  # noqa: ARG001
    """The wave of a driver that makes none."""
    return Still(0.0)


@law
def same_wave(valve, wave):  # noqa: ARG001
    """The wave of the next step of a driver that makes none."""
    return wave


@law
def same_whatever_share(valve, wave, share):  # noqa: ARG001
    """The wave of a driver whose wave is no dither that could be weaker."""
    return wave


def cannot_be_held(valve: Any, *_: Any) -> Any:
    """Refuse a failure that a kind of valve does not model."""
    raise KindError(f"a {type(valve).__name__} can't be seized: its kind says neither `seized` nor `held_at`")


@dataclass(frozen=True, kw_only=True)
class MeanValve:
    """The laws of a valve on average over the wave of its driver, for models that step in milliseconds.

    As in `ValveKind`; the wave says how much of the driver's there is.
    """

    averaged: Callable[[Any], Any]  # from the parameters of the valve to those on average
    parameter_type: type  # of these
    at_rest: Law
    move: Law
    opening: Law
    start_wave: Law
    turn_wave: Law = same_wave
    weaken_wave: Law = same_whatever_share
    seized: Law = cannot_be_held
    held_at: Law = cannot_be_held


@dataclass(frozen=True, kw_only=True)
class ValveKind(Kind):
    """A law of valves.

    `parameters(described)` yields a named tuple with at least the fields of `COMMON`, in SI units.
    """

    LAWS = ("at_rest", "move", "opening", "start_wave", "turn_wave")

    at_rest: Law = REQUIRED
    """`at_rest(valve)` yields the state of a valve that was never driven, a named tuple of floats."""
    move: Law = REQUIRED
    """`move(valve, state, command, wave, h)` yields the state after a step of h seconds at an opening asked for (-1 to
    1), and the mean conductances in it, m3/(s Pa), of the path that fills hose A and vents hose B and of the
    reverse."""
    opening: Law = REQUIRED  # `opening(valve, state)` yields the opening towards filling hose A, -1 to 1
    start_wave: Law = no_wave
    """`start_wave(valve, t, h)` yields what the driver makes by itself (dither, carrier) in the step that begins at t,
    a named tuple of floats; a driver makes nothing unless it is given."""
    turn_wave: Law = same_wave  # `turn_wave(valve, wave)` yields the same in the next step
    weaken_wave: Law = same_whatever_share  # `weaken_wave(valve, wave, share)` yields it with a share of the dither
    seized: Law = cannot_be_held  # `seized(valve)`, not a law, yields parameters of a valve that stays where it is
    held_at: Law = cannot_be_held
    """`held_at(valve, opening)`, not a law, yields the state of a valve at rest at an opening."""
    mean: MeanValve | None = None  # the valve on average over its wave; None where no such law is known

    def __post_init__(self) -> None:
        """Refuse parameters that lack what all valves have."""
        super().__post_init__()
        for cls in self.parameter_types:
            lacking = [name for name in COMMON if name not in getattr(cls, "_fields", ())]
            if lacking:
                raise KindError(f"{cls.__name__} lacks {', '.join(lacking)}", where=f"kind {self.name!r} of valve")

    def guarded(self) -> "ValveKind":
        """Return the kind with conductances that are not numbers where they would be negative."""
        return replace(self, move=_not_negative(self.move))

    def try_laws(self, parameters: Any, *_: Any) -> None:
        """Drive a valve, and check what the laws return; raise KindError if they return something else."""
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
            for command in TRIED:
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

    def entries(self) -> Mapping[type, Any]:
        """Return the holder of the laws by class of the parameters."""
        own = super().entries()
        return own if self.mean is None else {**own, self.mean.parameter_type: self.mean}


def _not_negative(move_of: Law) -> Law:
    @law
    def move(valve, state, command, wave, h):
        after, filling, venting = move_of(valve, state, command, wave, h)
        return after, select(filling < 0.0, nan, filling), select(venting < 0.0, nan, venting)

    return move
