"""Valves of a sized arm: proportional valves of the flows that are sold.

A valve's nominal flow is what it lets through fully open from 6 to 5 bar gauge, which with its critical ratio says its
conductance (ISO 6358).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.design.arm.moves import Moves
from layflat.errors import DesignError
from layflat.machine import Machine
from layflat.motion.dynamics import hose_torques, rigid_torques
from layflat.motion.limits import abilities
from layflat.physics.flow import effective_pressure, laminar_slope
from layflat.physics.joint import FILLED

# In which 5/3-way proportional valves with a 0 to 10 V input are commonly sold, in connections from M5 to G 3/8.
NOMINAL_FLOWS = (100, 350, 700, 1400, 2000)  # l/min, at 20 degC and 1 bar
NOMINAL_PRESSURES = 6e5, 5e5  # before and behind the valve, Pa gauge


class Valve(NamedTuple):
    """A valve that is sold."""

    nominal_flow: float  # l/min
    size: float  # its flow over that of the machine's valve


def valve_sizes(machine: Machine, moves: Moves, payload: float) -> Array:
    """Return the flow over that of a machine's valve that moves take with a payload (kg) of each joint, (joints,)."""
    able, states = abilities(machine), moves.states
    times = moves.times[:, None, None] / (moves.instants - 1)
    # Air that turns a joint is missing for its torque.
    held = able.stiffness * states.angles
    steps = np.diff(moves.by_move(rigid_torques(machine, states, payload) + held), axis=1) / times
    shares = moves.by_move(hose_torques(machine, able, states, payload) / able.torque)
    before = 0.5 * (shares[:, 1:] + shares[:, :-1]) * np.sign(steps)
    rates = np.abs(steps) / (able.rate * _share_of_rate(machine, before))
    speeds = np.abs(states.velocities).max(axis=0) / able.speed
    needed: Array = np.maximum(speeds, rates.max(axis=(0, 1)))
    return needed


def _share_of_rate(machine: Machine, shares: Array) -> Array:
    """Return how fast torques change with a valve open, over that in the middle, where a joint gives these shares.

    Shares of its torque are positive where the torque grows: then the fuller hose is filled, up to the supply's
    pressure and no further, and the other one vented.
    """
    given = np.linspace(-1.0, 1.0, 81)
    rates = [_rate(machine, float(share)) for share in given]
    found: Array = np.interp(shares, given, rates) / _rate(machine, 0.0)
    return found


def _rate(machine: Machine, share: float) -> float:
    supply, outside = machine.supply.pressure, machine.supply.ambient_pressure
    apart = abs(share) * machine.supply.pressure_gauge
    full = min(FILLED * supply + 0.5 * apart, supply)
    empty = max(full - apart, outside)
    filled, vented = (full, empty) if share > 0.0 else (empty, full)
    return _passed(machine, supply, filled) + _passed(machine, vented, outside)


def _passed(machine: Machine, before: float, behind: float) -> float:
    """Return what a valve lets through fully open, over its conductance, Pa."""
    b = 0.0 if machine.valve is None else machine.valve.critical_ratio
    return float(effective_pressure(before, behind, b, float(laminar_slope(b))))


def sold_valves(machine: Machine) -> tuple[Valve, ...]:
    """Return the valves that are sold, the smallest first, beside the one that a machine has."""
    if machine.valve is None:
        return ()
    outside = machine.supply.ambient_pressure
    passed = _passed(machine, *(pressure + outside for pressure in NOMINAL_PRESSURES))
    return tuple(Valve(flow, flow / 60e3 / passed / machine.valve.conductance) for flow in NOMINAL_FLOWS)


def choose(sold: Sequence[Valve], size: float, where: str) -> Valve:
    """Return the smallest valve of a flow over that of the machine's; raise DesignError naming `where`."""
    for valve in sold:
        if size <= valve.size:
            return valve
    largest = sold[-1]
    what = f"needs a valve of {largest.nominal_flow * size / largest.size:.0f} l/min, {size / largest.size:.2f} times"
    right = "ask for more time, or for less reach or payload"
    raise DesignError(f"{what} the largest that is sold", where=where, right=right)
