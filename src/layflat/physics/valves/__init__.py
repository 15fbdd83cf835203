"""Valves between supply, exhaust and a joint's two hoses, of any kind: conductances, and the flow of air.

A kind of valve is a law that moves it and yields the conductances of its two paths: the one that fills hose A and vents
hose B, and the reverse. A new kind is one file and one line here; see docs/kinds.md.
"""

from layflat.jit import law
from layflat.kinds import KindTable
from layflat.physics.driver import delay_command
from layflat.physics.flow import ENTHALPY, flow_between
from layflat.physics.valves import spool, switching
from layflat.physics.valves.kind import DitherPart, ValveKind, ValvePart

VALVE_KINDS: KindTable[ValveKind] = KindTable("valve", spool.KIND, switching.KIND)

at_rest = VALVE_KINDS.law("at_rest")
start_wave = VALVE_KINDS.law("start_wave")
turn_wave = VALVE_KINDS.law("turn_wave")
weaken_wave = VALVE_KINDS.law("weaken_wave")
move = VALVE_KINDS.law("move")
net_opening = VALVE_KINDS.law("opening")
seized = VALVE_KINDS.law("seized")
held_at = VALVE_KINDS.law("held_at")

__all__ = [
    "VALVE_KINDS",
    "DitherPart",
    "ValveKind",
    "ValvePart",
    "at_rest",
    "chamber_flow",
    "commanded_opening",
    "driven_opening",
    "held_at",
    "move",
    "net_opening",
    "seized",
    "start_wave",
    "turn_wave",
    "weaken_wave",
]


@law
def commanded_opening(valve, voltage):
    """Return the opening that a control voltage commands, -1..1, without dither."""
    return min(max((voltage - valve.centre_voltage) / valve.volts_to_full, -1.0), 1.0)


@law
def driven_opening(valve, line, voltage, cycle):
    """Return the mean opening that a valve is driven to in this cycle, and the delay line after it.

    Args: `cycle`: control cycle, s.
    """
    return delay_command(line, commanded_opening(valve, voltage), valve.delay / cycle)


@law
def chamber_flow(valve, C_in, C_out, p, roots, p_supply, roots_supply, p_exhaust):
    """Return the flows of a chamber that paths of conductance C_in and C_out connect to supply and exhaust.

    They are mass flow in (kg/s), enthalpy flow in (W), and the mass flow out of the supply (kg/s).
    """
    b, s = valve.critical_ratio, valve.laminar_slope
    inflow, warm_in = flow_between(C_in, b, s, p_supply, roots_supply, p, roots)
    outflow, warm_out = flow_between(C_out, b, s, p, roots, p_exhaust, roots_supply)
    return inflow - outflow, ENTHALPY * (warm_in - warm_out), inflow
