"""Choice of tubes and valves of a sized arm.

Links are round aluminium tubes whose deflection under the torque of their joint is limited. Valves are proportional
valves of the nominal flows that are sold: the flow of an open valve from 6 to 5 bar gauge, from which its conductance
follows with its critical ratio (ISO 6358).

| symbol | meaning | unit |
|---|---|---|
| T, L | torque at one end, length | N m, m |
| D, w | mean diameter and wall of the tube | m |
| E, I | modulus, second moment of its cross-section, pi/8 D^3 w | Pa, m4 |

The deflection of a cantilever tube under a force at its free end, with the torque T at its clamp, is T L^2/(3 E I).
"""

from collections.abc import Sequence
from math import hypot, pi
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.design.arm.moves import TaskMoves
from layflat.errors import DesignError
from layflat.machine import Machine
from layflat.motion.dynamics import hose_torques, rigid_torques
from layflat.motion.limits import joint_capabilities
from layflat.physics.flow import effective_pressure, laminar_slope
from layflat.physics.joint import REST_PRESSURE_RATIO

DENSITY, MODULUS = 2700.0, 70e9  # of aluminium, kg/m3 and Pa
WALL_THICKNESS = 2e-3  # m
# Outer diameters, m, in which tubes with this wall are commonly sold.
TUBE_DIAMETERS = tuple(1e-3 * D for D in (25, 30, 35, 40, 45, 50, 60, 70, 80, 90, 100, 120, 150, 180, 200))
MIN_TUBE_LENGTH = 50e-3  # tube that stands for the bracket of a link without length, m
MAX_DEFLECTION = 0.5e-3  # of a tube's end per length, m/m


class Tube(NamedTuple):
    """Tube of a link of a sized arm."""

    length: float  # m
    diameter: float  # outer, m

    @property
    def mass(self) -> float:
        """Mass of the tube, kg."""
        return pi * (self.diameter - WALL_THICKNESS) * WALL_THICKNESS * self.length * DENSITY

    @property
    def moments(self) -> tuple[float, float]:
        """Inertias about its middle, along and across its length, kg m2."""
        mean = self.diameter - WALL_THICKNESS
        along = 0.25 * self.mass * (mean**2 + WALL_THICKNESS**2)
        return along, 0.5 * along + self.mass * self.length**2 / 12.0


def choose_tube(link: tuple[float, float, float], torque: float, where: str) -> Tube:
    """Return the thinnest tube that is stiff enough for a link.

    Args:
        link: vector of the link, m.
        torque: max torque of its joint, N m.
        where: name of the link in messages.

    Raises:
        DesignError: naming `where`: no tube is stiff enough.
    """
    length = max(hypot(*link), MIN_TUBE_LENGTH)
    second_moment = torque * length / (3.0 * MODULUS * MAX_DEFLECTION)
    diameter = (8.0 * second_moment / (pi * WALL_THICKNESS)) ** (1.0 / 3.0) + WALL_THICKNESS
    if diameter > TUBE_DIAMETERS[-1]:
        what = f"a link of {1e3 * length:.0f} mm under {torque:.0f} N m needs a tube of {1e3 * diameter:.0f} mm"
        raise DesignError(
            what, where=where, right=f"at most {1e3 * TUBE_DIAMETERS[-1]:.0f} mm: ask for less reach or payload"
        )
    return Tube(length, next(D for D in TUBE_DIAMETERS if diameter <= D))


# Of 5/3-way proportional valves with a 0 to 10 V input that are commonly sold, with connections from M5 to G 3/8.
NOMINAL_FLOWS = (100, 350, 700, 1400, 2000)  # l/min, at 20 degC and 1 bar
NOMINAL_PRESSURES = 6e5, 5e5  # before and behind the valve, Pa gauge


class Valve(NamedTuple):
    """Valve that is commonly sold."""

    nominal_flow: float  # l/min
    size: float  # its flow over that of the machine's valve


def valve_sizes(machine: Machine, moves: TaskMoves, payload: float) -> Array:
    """Return the flow of the valve that each joint needs for moves, over that of the machine's valve, (joints,).

    Args:
        machine: machine with the arm's joints.
        moves: moves of the task.
        payload: kg.
    """
    able, states = joint_capabilities(machine), moves.states
    times = moves.times[:, None, None] / (moves.instants - 1)
    # Air that moves a joint does not change its torque.
    held = able.stiffness * states.angles
    steps = np.diff(moves.by_move(rigid_torques(machine, states, payload) + held), axis=1) / times
    shares = moves.by_move(hose_torques(machine, able, states, payload) / able.torque)
    before = 0.5 * (shares[:, 1:] + shares[:, :-1]) * np.sign(steps)
    rates = np.abs(steps) / (able.rate * _share_of_rate(machine, before))
    speeds = np.abs(states.velocities).max(axis=0) / able.speed
    needed: Array = np.maximum(speeds, rates.max(axis=(0, 1)))
    return needed


def _share_of_rate(machine: Machine, shares: Array) -> Array:
    """Return the rate of the torque with an open valve, over that at zero torque, at shares of a joint's torque.

    Shares are positive if the magnitude of the torque grows: then the fuller hose is filled, up to the supply's
    pressure, and the other one vented.
    """
    nodes = np.linspace(-1.0, 1.0, 81)
    rates = [_torque_rate_per_conductance(machine, float(share)) for share in nodes]
    ratios: Array = np.interp(shares, nodes, rates) / _torque_rate_per_conductance(machine, 0.0)
    return ratios


def _torque_rate_per_conductance(machine: Machine, share: float) -> float:
    """Return the torque rate of an open valve in units of its conductance, Pa, at a share (-1..1) of a joint's torque.

    With a positive share the fuller hose is filled and the other one vented, so that the torque's magnitude grows.
    """
    supply, outside = machine.supply.pressure, machine.supply.ambient_pressure
    apart = abs(share) * machine.supply.pressure_gauge
    full = min(REST_PRESSURE_RATIO * supply + 0.5 * apart, supply)
    empty = max(full - apart, outside)
    filled, vented = (full, empty) if share > 0.0 else (empty, full)
    return _passed(machine, supply, filled) + _passed(machine, vented, outside)


def _passed(machine: Machine, before: float, behind: float) -> float:
    """Return the flow of an open valve from one pressure to another, over its conductance, Pa."""
    b = 0.0 if machine.valve is None else machine.valve.critical_ratio
    return float(effective_pressure(before, behind, b, float(laminar_slope(b))))


def sold_valves(machine: Machine) -> tuple[Valve, ...]:
    """Return the valves that are sold, the smallest first, sizes relative to a machine's; none if it has no valve."""
    if machine.valve is None:
        return ()
    outside = machine.supply.ambient_pressure
    passed = _passed(machine, *(pressure + outside for pressure in NOMINAL_PRESSURES))
    return tuple(Valve(flow, flow / 60e3 / passed / machine.valve.conductance) for flow in NOMINAL_FLOWS)


def choose_valve(sold: Sequence[Valve], size: float, where: str) -> Valve:
    """Return the smallest valve that is large enough.

    Args:
        sold: valves, the smallest first.
        size: needed flow over that of the machine's valve.
        where: name of the joint in messages.

    Raises:
        DesignError: naming `where`: no valve is large enough.
    """
    for valve in sold:
        if size <= valve.size:
            return valve
    largest = sold[-1]
    what = f"needs a valve of {largest.nominal_flow * size / largest.size:.0f} l/min, {size / largest.size:.2f} times"
    right = "ask for more time, or for less reach or payload"
    raise DesignError(f"{what} the largest that is sold", where=where, right=right)
