"""A scenario as arrays over control cycles, checked against the machine that it acts on."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError
from layflat.machine import Machine, parameters
from layflat.machine.signal_ranges import check_signal
from layflat.motion.kinematics import tip_position
from layflat.motion.rates import derived_rates, lasting_rate
from layflat.motion.signal_rows import expand_signal
from layflat.motion.signal_values import Sampling, SignalKind, single_kind
from layflat.motion.tip_demand import axes_of, demand_of_tip
from layflat.physics.noise import sensor_noise
from layflat.sim.kernel import Signals
from layflat.sim.scenario import Scenario, start_row

TRAVEL_RATIO, TRAVEL_ROUNDING = 2.0, 1e-3
"""A velocity may carry a joint this many times as far as its demand goes, and so much further (rad)."""

CheckTravel = Callable[[Array, Array, float, str], None]

MAX_STEP = 4.0  # times what its velocity allows in a cycle; a demand that moves further jumps

DISTURBANCES: dict[str, tuple[u.Quantity | None, float]] = {
    "demand_stiffness": (u.STIFFNESS, 0.0),
    "brake": (None, 1.0),
    "dither": (None, 1.0),
    "opening": (None, 0.0),
    "load": (u.TORQUE, 0.0),
    "drift": (u.VOLTAGE, 0.0),
}
"""Signals with a value a joint: their kind, and their value before the first step."""


class Shapes(NamedTuple):
    """A scenario as arrays over control cycles, before a machine is known; not a number: as usual."""

    demand: Array  # rad, (cycles, joints)
    rates: tuple[Array, Array]  # of the demand, rad/s and rad/s2, (cycles, joints) each
    stiffness: Array  # asked for, N m/rad, (cycles, joints)
    opening: Array  # -1..1, (cycles, joints); not a number where the controller or a voltage drives
    voltage: Array  # V, (cycles, joints); not a number where the controller or an opening drives
    brake: Array  # share of the brake's torque, (cycles, joints)
    dither: Array  # share of the valve's dither, (cycles, joints)
    load: Array  # N m, (cycles, joints)
    drift: Array  # V, (cycles, joints)
    supply: Array  # gauge pressure, Pa, (cycles,)
    payload: Array  # kg, (cycles,)

    @property
    def by_joint(self) -> Array:
        """All that differs from joint to joint, in this order, (cycles, joints, 10)."""
        asked = (self.demand, *self.rates, self.stiffness)
        return np.stack((*asked, self.opening, self.voltage, self.brake, self.dither, self.load, self.drift), axis=-1)


def shapes(scenario: Scenario, machine: Machine, cycle: float, *, plausible: bool = True) -> Shapes:
    """Return a scenario as arrays over control cycles.

    Args:
        scenario: all that happens.
        machine: the machine that it happens to.
        cycle: control cycle, s.
        plausible: whether values that the machine can't have are refused; logs may hold such.

    Raises:
        InputError: naming the field: a value without unit, of a wrong kind, not finite, out of range, or after the end;
            a demand outside the stroke, or one that its velocity contradicts.
    """
    sampling, names = Sampling(cycle, scenario.cycles(cycle)), list(machine.joints)
    checked = partial(check_signal, machine) if plausible else lambda _, values: values

    def expand(name: str) -> Array:
        (quantity, usual), signal = DISTURBANCES[name], getattr(scenario, name)
        if signal is None and name == "opening":
            return np.full((sampling.cycles, len(names)), np.nan)
        rows = expand_signal(signal, SignalKind(name, quantity, names), np.full(len(names), usual), sampling)
        return checked(name, rows)

    def shared(name: str, quantity: u.Quantity) -> Array:
        if (signal := getattr(scenario, name)) is None:
            return np.full(sampling.cycles, np.nan)
        rows = expand_signal(signal, single_kind(name, quantity), np.array([np.nan]), sampling)
        return checked(name, np.ascontiguousarray(rows[:, 0]))

    demand = _demand(scenario, machine, sampling)
    for j, name in enumerate(names if scenario.closed_loop else ()):
        worst = float(demand[np.argmax(np.abs(demand[:, j])), j])
        parameters.check_inside_stroke(machine, name, worst, "demand" if scenario.tip is None else "tip")
    return Shapes(
        demand,
        _rates(scenario, machine, demand, sampling, checked, _check_travel if plausible else None),
        expand("demand_stiffness"),
        expand("opening"),
        _voltage(scenario, machine, sampling, checked),
        expand("brake"),
        expand("dither"),
        expand("load"),
        expand("drift"),
        shared("supply", u.PRESSURE),
        shared("payload", u.MASS),
    )


def _voltage(scenario: Scenario, machine: Machine, sampling: Sampling, checked: Any) -> Array:
    """Return control voltages, of joints that are not named those at which their valves are closed."""
    names = list(machine.joints)
    if scenario.voltage is None:
        return np.full((sampling.cycles, len(names)), np.nan)
    centre = 0.0 if machine.valve is None else machine.valve.centre_voltage
    kind = SignalKind("voltage", u.VOLTAGE, names)
    voltage: Array = checked("voltage", expand_signal(scenario.voltage, kind, np.full(len(names), centre), sampling))
    return voltage


def _demand(scenario: Scenario, machine: Machine, sampling: Sampling) -> Array:
    """Return the demand, (cycles, joints), rad: as given, or angles that bring the tip to where it is asked for."""
    start = start_row(scenario, machine)
    start = np.zeros(len(machine.joints)) if start is None else start
    if scenario.tip is None:
        return expand_signal(scenario.demand, SignalKind("demand", u.ANGLE, list(machine.joints)), start, sampling)
    axes = axes_of(machine)
    places = expand_signal(
        scenario.tip, SignalKind("tip", u.LENGTH, axes, "axis"), tip_position(machine, start), sampling
    )
    return demand_of_tip(machine, places, start, "tip")


def _rates(
    scenario: Scenario,
    machine: Machine,
    demand: Array,
    sampling: Sampling,
    checked: Any,
    check_travel: CheckTravel | None,
) -> tuple[Array, Array]:
    """Return velocity and acceleration of the demand: as given, else as it moves on."""
    cycle, names = sampling.cycle, list(machine.joints)
    rates = derived_rates(demand, sampling.cycle)

    def expand(name: str, quantity: u.Quantity, moved: Array) -> Array:
        kind = SignalKind(name, quantity, names)
        rows: Array = checked(name, expand_signal(getattr(scenario, name), kind, np.zeros(demand.shape[1]), sampling))
        if check_travel is not None:
            check_travel(rows, moved, cycle, name)
        return rows

    if scenario.demand_velocity is not None:
        velocity = expand("demand_velocity", u.ANGULAR_SPEED, demand)
        rates = velocity, lasting_rate(velocity, cycle)
    if scenario.demand_acceleration is not None:
        rates = rates[0], expand("demand_acceleration", u.ANGULAR_ACCELERATION, rates[0])
    return rates


def _check_travel(rate: Array, moved: Array, cycle: float, where: str) -> None:
    """Refuse a rate that goes much further than what it is the rate of: the two contradict each other."""
    speed = np.abs(rate)
    travel = cycle * speed.sum(axis=0)
    # Of a jump no more counts than the rate around it may go.
    steps = np.minimum(np.abs(np.diff(moved, axis=0)), MAX_STEP * cycle * np.maximum(speed[:-1], speed[1:]))
    moves = steps.sum(axis=0)
    # The rate of the last cycle has no step of its own.
    excess = travel - (TRAVEL_RATIO * moves + TRAVEL_ROUNDING + cycle * speed.max(axis=0))
    if np.any(excess > 0.0):
        j = int(np.argmax(excess))
        unit, of = ("rad", "the demand") if where == "demand_velocity" else ("rad/s", "its velocity")
        what = f"goes through {travel[j]:.4g} {unit} where {of} changes by {moves[j]:.4g} {unit}"
        raise InputError(what, where=where, right="give a demand that moves on so, or leave it out")


def signals(scenario: Scenario, machine: Machine, cycle: float) -> Signals:
    """Return all that acts on a machine in a scenario.

    Raises:
        InputError: as `shapes`; or a voltage stands beside a demand.
    """
    if scenario.voltage is not None and (scenario.asks_for_angles or scenario.tip is not None):
        what = "stands beside a demand, which a run that follows voltages does not"
        raise InputError(what, where="voltage", right="give one or the other")
    own = shapes(scenario, machine, cycle)
    brakes = np.array([joint.brake.torque for joint in machine.joints.values()])
    gauge = np.where(np.isnan(own.supply), machine.supply.pressure_gauge, own.supply)
    return Signals(
        own.demand,
        np.stack(own.rates, axis=-1),
        own.stiffness,
        _opening(own, machine),
        own.brake * brakes,
        own.dither,
        own.load,
        own.drift,
        gauge + machine.supply.ambient_pressure,
        np.where(np.isnan(own.payload), machine.arm.payload, own.payload),
        sensor_noise(scenario.seed if scenario.noise else None, len(own.demand) + 1, own.demand.shape[1]),
    )


def _opening(own: Shapes, machine: Machine) -> Array:
    """Return openings asked for; not a number where the controller drives."""
    if machine.valve is None or np.isnan(own.voltage).all():
        return own.opening
    return (own.voltage - machine.valve.centre_voltage) / machine.valve.volts_to_full
