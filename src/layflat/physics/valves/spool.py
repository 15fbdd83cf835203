"""A 5/3 proportional spool valve and its driver: dither moves the spool, the spool opens one path and shuts the other.

| symbol | meaning | unit |
|---|---|---|
| x | spool opening, positive: hose A to supply, hose B to exhaust | 1 |
"""

from math import pi
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field

from layflat.description import Part
from layflat.description import units as u
from layflat.jit import law
from layflat.physics.arrays import itemwise
from layflat.physics.dither import half_change, start_dither, turn_dither, weakened
from layflat.physics.flow import laminar_slope
from layflat.physics.friction.stribeck import StaticRatio
from layflat.physics.valves import spool_ports
from layflat.physics.valves.kind import Dither, ValveKind, ValvePart
from layflat.physics.valves.spool_motion import Spool, SpoolState, StictionSpool, advance_spool, centred, spool_opening
from layflat.physics.valves.spool_ports import mean_conductances

STUCK = 1e9  # friction that no solenoid overcomes, as a change of opening


class SpoolValve(NamedTuple):
    """Parameters of a spool valve with its driver."""

    spool: Spool | StictionSpool
    conductance: float
    leakage: float
    critical_ratio: float
    laminar_slope: float
    overlap: float
    centre_voltage: float
    volts_to_full: float
    dither_amplitude: float
    dither_frequency: float
    delay: float  # from the command to the spool, s


class Stiction(Part):
    """Friction of a spool at rest, and its fall as the spool begins to slide."""

    static_ratio: StaticRatio = Field(description="static over kinetic friction, 1 or more")
    velocity: u.Rate = Field(description="at which half of the difference is gone, full openings per second")


class SpoolValvePart(ValvePart):
    """A 5/3 proportional spool valve."""

    kind: Literal["spool"] = "spool"
    overlap: Annotated[u.Share, Field(lt=0.9)] = Field(
        description="share of the stroke in which a land covers its port"
    )
    natural_frequency: u.ValveFrequency
    damping_ratio: u.Ratio
    friction: u.Share = Field(description="change of command that the spool's friction can hide, share of full opening")
    dither: Dither
    stiction: Stiction | None = Field(
        default=None, description="static friction above `friction`, which is then kinetic; default: none"
    )

    @property
    def dithered(self) -> Dither | None:
        """The dither, where it has an amplitude."""
        return self.dither if self.dither.amplitude > 0.0 else None

    @property
    def wave_frequency(self) -> float | None:
        """Frequency of its dither, where that has an amplitude."""
        return self.dither.frequency if np.any(self.dither.amplitude > 0.0) else None

    @property
    def least_dither(self) -> float:
        """Dither that is described."""
        return self.dither.least

    @property
    def covered(self) -> float:
        """The overlap."""
        return self.overlap


def parameters(described: SpoolValvePart) -> SpoolValve:
    """Spool valve with its driver."""
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
    """Dither of the step of h seconds that begins at t."""
    return start_dither(valve.dither_frequency, t, h)


@law
def move_spool(valve, state, command, dither, h):
    """State after a step of h seconds, and the mean conductances of the paths that fill and that vent hose A."""
    u = command + valve.dither_amplitude * dither.sine
    swing = valve.dither_amplitude * half_change(dither)
    x, rate = advance_spool(valve.spool, u, swing, state.opening, state.rate, h)
    fills, vents = mean_conductances(valve, state.opening, x)
    return SpoolState(x, rate), fills, vents


@law
def turn_spool_wave(valve, dither):  # noqa: ARG001
    """Dither of the next step."""
    return turn_dither(dither)


@law
def weaken_spool_wave(valve, dither, share):  # noqa: ARG001
    """A share of the dither."""
    return weakened(dither, share)


def seized(valve: SpoolValve) -> SpoolValve:
    """A valve whose spool stays where it is, whatever is asked of it."""
    return valve._replace(spool=valve.spool._replace(friction=STUCK))


def held_at(valve: SpoolValve, opening: float) -> SpoolState:  # noqa: ARG001
    """State of a spool at rest at an opening, -1 to 1."""
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
    mean=spool_ports.MEAN,
)
