"""Valves of a sized arm: proportional valves of the flows that are sold.

A valve's nominal flow is what it lets through fully open from 6 to 5 bar gauge, which with its critical ratio says its
conductance (ISO 6358).
"""

from collections.abc import Iterator
from typing import NamedTuple

from layflat.machine import Machine
from layflat.physics.flow import effective_pressure, laminar_slope

# In which 5/3-way proportional valves with a 0 to 10 V input are commonly sold, in connections from M5 to G 3/8.
NOMINAL_FLOWS = (100, 350, 700, 1400, 2000)  # l/min, at 20 degC and 1 bar
NOMINAL_PRESSURES = 6e5, 5e5  # before and behind the valve, Pa gauge


class Valve(NamedTuple):
    """A valve that is sold."""

    nominal_flow: float  # l/min
    size: float  # its flow over that of the machine's valve


def valves(machine: Machine) -> Iterator[Valve]:
    """Yield the valves that are sold, the smallest first, beside the one that a machine has."""
    valve, outside = machine.valve, machine.supply.ambient_pressure
    if valve is None:
        return
    before, behind = (pressure + outside for pressure in NOMINAL_PRESSURES)
    passed = float(effective_pressure(before, behind, valve.critical_ratio, float(laminar_slope(valve.critical_ratio))))
    for flow in NOMINAL_FLOWS:
        conductance = flow / 60e3 / passed
        yield Valve(flow, conductance / valve.conductance)
