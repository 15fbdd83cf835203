"""The valve between supply, exhaust and a joint's two hoses, of any kind: what it lets through, and the air that flows.

A kind of valve is a law that moves it and yields the conductances of its two paths: the one that fills hose A and vents
hose B, and the reverse.
"""

from layflat.jit import by_kind, law
from layflat.physics import spool_valve, switching_valve
from layflat.physics.delay import delayed
from layflat.physics.dither import Dither, turn_dither
from layflat.physics.flow import flow_between
from layflat.physics.spool_valve import SpoolState, SpoolValve
from layflat.physics.switching_valve import Carrier, PairState, SwitchingPair

Valve = SpoolValve | SwitchingPair
ValveState = SpoolState | PairState

at_rest = by_kind({SpoolValve: spool_valve.centred, SwitchingPair: switching_valve.shut})
"""State of a valve that was never driven: `at_rest(valve)`."""

start_wave = by_kind({SpoolValve: spool_valve.start_spool_wave, SwitchingPair: switching_valve.start_carrier})
"""What the driver makes by itself, dither or carrier, in the step of h that begins at t: `start_wave(valve, t, h)`."""

turn_wave = by_kind({Dither: turn_dither, Carrier: switching_valve.turn_carrier})
"""The same in the next step: `turn_wave(wave)`."""

move = by_kind({SpoolValve: spool_valve.move_spool, SwitchingPair: switching_valve.move_pair})
"""State after a step of h, and mean conductances (m3/(s Pa)) in it: `move(valve, state, command, wave, h)`."""

net_opening = by_kind({SpoolState: spool_valve.spool_opening, PairState: switching_valve.pair_opening})
"""Opening towards filling hose A, -1..1: `net_opening(state)`."""


@law
def commanded_opening(valve, voltage):
    """Opening that the driver asks for at a control voltage, -1..1, without dither."""
    return min(max((voltage - valve.centre_voltage) / valve.volts_to_full, -1.0), 1.0)


@law
def driven(valve, line, voltage, cycle):
    """Opening to which a voltage drives a valve in this cycle, and the line of commands after it."""
    return delayed(line, commanded_opening(valve, voltage), valve.delay / cycle)


@law
def chamber_flow(valve, C_in, C_out, p, warmth, p_supply, warmth_supply, p_exhaust):
    """Flows of a chamber joined to supply and exhaust by paths of conductance C_in and C_out.

    Returns mass flow in (kg/s), enthalpy flow in (W), and the mass flow taken from the supply (kg/s).
    """
    b, s = valve.critical_ratio, valve.laminar_slope
    inflow, heat_in = flow_between(C_in, b, s, p_supply, warmth_supply, p, warmth)
    outflow, heat_out = flow_between(C_out, b, s, p, warmth, p_exhaust, warmth_supply)
    return inflow - outflow, heat_in - heat_out, inflow
