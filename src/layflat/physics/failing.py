"""What goes wrong with a joint: a spool that sticks, a kinked hose, a hose with a hole."""

from __future__ import annotations

from math import inf

from layflat.jit import law
from layflat.physics.chamber import air_mass, energy, pressure, temperature
from layflat.physics.joint import HoseState
from layflat.physics.spool_valve import SpoolState, SpoolValve
from layflat.physics.switching_valve import PairState, SwitchingPair, SwitchState
from layflat.physics.valve import Valve, ValveState

BURST_TIME = 0.02
"""Time constant with which a burst hose loses its air, s."""

STUCK = 1e9
"""Friction that no solenoid overcomes, as a change of opening."""


def seized(valve: Valve) -> Valve:
    """A valve that stays where it is, whatever is asked of it."""
    if isinstance(valve, SpoolValve):
        return valve._replace(spool=valve.spool._replace(friction=STUCK))
    return valve._replace(switch=valve.switch._replace(opening_time=inf, closing_time=inf))


def kinked(valve: Valve, share: float) -> Valve:
    """A valve behind a kink that lets through a share of what the valve does."""
    return valve._replace(conductance=share * valve.conductance, leakage=share * valve.leakage)


def held_at(valve: Valve, opening: float) -> ValveState:
    """State of a valve at rest at an opening, -1 to 1."""
    if isinstance(valve, SwitchingPair):
        return PairState(SwitchState(0.0, max(opening, 0.0)), SwitchState(0.0, max(-opening, 0.0)))
    return SpoolState(opening, 0.0)


@law
def through_hole(hose, state, share, p_a):
    """State of a hose that has lost a share of its pressure above the outside (p_a, Pa), as warm as before."""
    V = state.volume
    p = pressure(hose.chamber, state.energy, V, p_a)
    T = temperature(hose.chamber, p, state.mass, V, p_a)
    p = p - share * (p - p_a)
    return HoseState(
        energy(hose.chamber, p, V, p_a),
        air_mass(hose.chamber, p, T, V, p_a),
        V,
        p,
        state.pressure_change,
        state.mass_change,
        state.loss_1,
        state.loss_2,
        state.loss_3,
    )
