"""A 5/3 proportional spool valve: which share of its full conductance joins each hose to supply and exhaust.

| symbol | meaning | unit |
|---|---|---|
| x | spool opening, positive: hose A to supply, hose B to exhaust | 1 |
| o | overlap: the share of the stroke in which a land covers its port | 1 |
| C | sonic conductance of a fully open path | m3/(s Pa) |
| C_0 | leakage conductance of a closed path | m3/(s Pa) |
"""

from typing import NamedTuple

from layflat.jit import law
from layflat.physics.flow import flow_between
from layflat.physics.ramp import mean_above_zero
from layflat.physics.spool import Spool


class Valve(NamedTuple):
    """Parameters of a valve with its driver."""

    spool: Spool
    conductance: float
    leakage: float
    critical_ratio: float
    laminar_slope: float
    overlap: float
    centre_voltage: float
    volts_to_full: float
    dither_amplitude: float
    dither_frequency: float


@law
def commanded_opening(valve, voltage):
    """Opening that the driver asks for at a control voltage, -1..1, without dither."""
    return min(max((voltage - valve.centre_voltage) / valve.volts_to_full, -1.0), 1.0)


@law
def path_conductance(valve, x):
    """Conductance of the path that a positive x opens, m3/(s Pa)."""
    share = max(x - valve.overlap, 0.0) * (1.0 / (1.0 - valve.overlap))
    return valve.leakage + (valve.conductance - valve.leakage) * share


@law
def mean_conductance(valve, x_0, x_1):
    """Mean conductance of the path that a positive x opens, while x moves evenly from x_0 to x_1, m3/(s Pa)."""
    share = mean_above_zero(x_0 - valve.overlap, x_1 - valve.overlap) * (1.0 / (1.0 - valve.overlap))
    return valve.leakage + (valve.conductance - valve.leakage) * share


@law
def chamber_flow(valve, C_in, C_out, p, warmth, p_supply, warmth_supply, p_exhaust):
    """Flows of a chamber joined to supply and exhaust by paths of conductance C_in and C_out.

    Returns mass flow in (kg/s), enthalpy flow in (W), and the mass flow taken from the supply (kg/s).
    """
    b, s = valve.critical_ratio, valve.laminar_slope
    inflow, heat_in = flow_between(C_in, b, s, p_supply, warmth_supply, p, warmth)
    outflow, heat_out = flow_between(C_out, b, s, p, warmth, p_exhaust, warmth_supply)
    return inflow - outflow, heat_in - heat_out, inflow
