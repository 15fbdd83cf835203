"""The valve between supply, exhaust and a joint's two hoses, of any kind: what it lets through, and the air that flows.

A kind of valve is a law that moves it and yields the conductances of its two paths: the one that fills hose A and vents
hose B, and the reverse. A new kind is one file and one line here; see docs/kinds.md.
"""

from layflat.jit import law
from layflat.kinds import Table
from layflat.physics.delay import delayed
from layflat.physics.flow import ENTHALPY, flow_between
from layflat.physics.valves import spool, switching
from layflat.physics.valves.kind import Dither, ValveKind, ValvePart

VALVES: Table[ValveKind] = Table("valve", spool.KIND, switching.KIND)

at_rest = VALVES.law("at_rest")
start_wave = VALVES.law("start_wave")
turn_wave = VALVES.law("turn_wave")
weaken_wave = VALVES.law("weaken_wave")
move = VALVES.law("move")
net_opening = VALVES.law("opening")
seized = VALVES.law("seized")
held_at = VALVES.law("held_at")

__all__ = [
    "VALVES",
    "Dither",
    "ValveKind",
    "ValvePart",
    "at_rest",
    "chamber_flow",
    "commanded_opening",
    "driven",
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
    """Opening that the driver asks for at a control voltage, -1..1, without dither."""
    return min(max((voltage - valve.centre_voltage) / valve.volts_to_full, -1.0), 1.0)


@law
def driven(valve, line, voltage, cycle):
    """Opening to which a voltage drives a valve in this cycle, and the line of commands after it."""
    return delayed(line, commanded_opening(valve, voltage), valve.delay / cycle)


@law
def chamber_flow(valve, C_in, C_out, p, roots, p_supply, roots_supply, p_exhaust):
    """Flows of a chamber joined to supply and exhaust by paths of conductance C_in and C_out.

    Returns mass flow in (kg/s), enthalpy flow in (W), and the mass flow taken from the supply (kg/s).
    """
    b, s = valve.critical_ratio, valve.laminar_slope
    inflow, warm_in = flow_between(C_in, b, s, p_supply, roots_supply, p, roots)
    outflow, warm_out = flow_between(C_out, b, s, p, roots, p_exhaust, roots_supply)
    return inflow - outflow, ENTHALPY * (warm_in - warm_out), inflow
