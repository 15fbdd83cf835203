"""A 5/3 proportional spool valve and its driver: dither moves the spool, the spool opens one path and shuts the other.

| symbol | meaning | unit |
|---|---|---|
| x | spool opening, positive: hose A to supply, hose B to exhaust | 1 |
"""

from math import pi
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from layflat.description import Part
from layflat.description import units as u
from layflat.jit import law
from layflat.lazy import numpy as np
from layflat.physics.arrays import itemwise
from layflat.physics.driver import advance_dither, half_dither_change, scale_dither, start_dither
from layflat.physics.flow import laminar_slope
from layflat.physics.friction.stribeck import StaticRatio
from layflat.physics.valves import spool_laws
from layflat.physics.valves.kind import DitherPart, ValveKind, ValvePart
from layflat.physics.valves.spool_laws import (
    Spool,
    SpoolState,
    StictionSpool,
    advance_spool,
    centred,
    mean_conductances,
    spool_opening,
)

SEIZED_FRICTION = 1e9  # friction that no solenoid overcomes, as a change of the command


class SpoolValve(NamedTuple):
    """Parameters of a spool valve with its driver."""

    spool: Spool | StictionSpool
    conductance: float  # of a fully open path, m3/(s Pa)
    leakage: float  # conductance of a closed path, m3/(s Pa)
    critical_ratio: float  # critical pressure ratio
    laminar_slope: float  # slope of the flow near the pressure ratio 1
    overlap: float  # fraction of the stroke in which a land covers its port
    centre_voltage: float  # V
    volts_to_full: float  # change of the voltage to full opening, V
    dither_amplitude: float  # as a fraction of full command
    dither_frequency: float  # Hz
    delay: float  # from the command to the spool, s


class Stiction(Part):
    """Description of a spool's static friction, and its fall as the spool begins to slide."""

    static_ratio: StaticRatio = Field(description="static over kinetic friction, 1 or more")
    velocity: u.Rate = Field(description="at which half of the difference remains, full openings per second")


class SpoolValvePart(ValvePart):
    """Description of a 5/3 proportional spool valve."""

    kind: Literal["spool"] = "spool"
    overlap: Annotated[u.Share, Field(lt=0.9)] = Field(
        description="fraction of the stroke in which a land covers its port"
    )
    natural_frequency: u.ValveFrequency
    damping_ratio: u.Ratio
    friction: u.Share = Field(
        description="change of command to which the spool need not respond, fraction of full opening"
    )
    dither: DitherPart
    stiction: Stiction | None = Field(
        default=None, description="static friction above `friction`, which is then kinetic; default: none"
    )

    @property
    def dithered(self) -> DitherPart | None:
        """Dither; None where its amplitude is 0."""
        return self.dither if self.dither.amplitude > 0.0 else None

    @property
    def wave_frequency(self) -> float | None:
        """Frequency of its dither, Hz; None where the amplitude is 0."""
        return self.dither.frequency if np.any(self.dither.amplitude > 0.0) else None

    @property
    def min_dither(self) -> float:
        """Fraction of the dither that can't be switched off."""
        return self.dither.min

    @property
    def covered(self) -> float:
        """Overlap as a fraction of the stroke, as valves of all kinds name it."""
        return self.overlap


def parameters(described: SpoolValvePart) -> SpoolValve:
    """Return the parameters of a spool valve with its driver."""
    b, stiction = described.critical_ratio, described.stiction
    motion = (2 * pi * described.natural_frequency, described.damping_ratio, described.friction)
    return SpoolValve(
        Spool(*motion)
        if stiction is None
        else StictionSpool(*motion, stiction.static_ratio - 1.0, 1.0 / (stiction.velocity * stiction.velocity)),
        described.conductance,
        described.leakage,
        b,
        itemwise(laminar_slope, b),
        described.overlap,
        described.centre_voltage,
        described.volts_to_full,
        described.dither.amplitude,
        described.dither.frequency,
        described.delay,
    )


@law
def start_spool_wave(valve, t, h):
    """Return the dither of the step of h seconds that begins at t."""
    return start_dither(valve.dither_frequency, t, h)


@law
def move_spool(valve, state, command, dither, h):
    """Return the state after a step of h seconds, and the mean conductances of the paths that fill and vent hose A."""
    u = command + valve.dither_amplitude * dither.sine
    half_sweep = valve.dither_amplitude * half_dither_change(dither)
    x, rate = advance_spool(valve.spool, u, half_sweep, state.opening, state.rate, h)
    fills, vents = mean_conductances(valve, state.opening, x)
    return SpoolState(x, rate), fills, vents


@law
def turn_spool_wave(valve, dither):  # noqa: ARG001
    """Return the dither of the next step."""
    return advance_dither(dither)


@law
def weaken_spool_wave(valve, dither, share):  # noqa: ARG001
    """Return a fraction `share` of the dither."""
    return scale_dither(dither, share)


def seized(valve: SpoolValve) -> SpoolValve:
    """Return the parameters of a valve whose spool does not move, whatever the command."""
    return valve._replace(spool=valve.spool._replace(friction=SEIZED_FRICTION))


def held_at(valve: SpoolValve, opening: float) -> SpoolState:  # noqa: ARG001
    """Return the state of a spool at rest at an opening, -1 to 1."""
    return SpoolState(opening, 0.0)


KIND = ValveKind(
    name="spool",
    description=SpoolValvePart,
    parameters=parameters,
    parameter_types=(SpoolValve,),
    at_rest=centred,
    move=move_spool,
    opening=spool_opening,
    start_wave=start_spool_wave,
    turn_wave=turn_spool_wave,
    weaken_wave=weaken_spool_wave,
    seized=seized,
    held_at=held_at,
    mean=spool_laws.MEAN_LAWS,
)
