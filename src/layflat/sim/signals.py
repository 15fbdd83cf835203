"""A scenario as arrays over control cycles, checked against the machine that it acts on."""

from collections.abc import Mapping

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.change import value_at
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine, parameters
from layflat.motion.kinematics import tip_position
from layflat.motion.labelled import is_labelled, labelled_row
from layflat.motion.plausible import HOSE_PRESSURE, centre_voltage
from layflat.motion.rates import derived_rates, lasting_rate
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.motion.signal_rows import expand_signal, is_steps
from layflat.motion.signal_values import Sampling, SignalKind, check_names, read_number, read_row
from layflat.motion.tip_demand import axes_of, demand_of_tip
from layflat.sim.cycle import Acting, Around, Signals

TRAVEL_RATIO, TRAVEL_ROUNDING = 2.0, 1e-3
"""A velocity may carry a joint this many times as far as its demand goes, and so much further (rad)."""

MAX_STEP = 4.0  # times what its velocity allows in a cycle; a demand that moves further jumps


def expand(scenario: Scenario, machine: Machine, cycle: float, *, plausible: bool = True) -> Signals:
    """Return a scenario as arrays over control cycles; what is not given is not a number.

    Args:
        scenario: all that happens.
        machine: the machine that it happens to.
        cycle: control cycle, s.
        plausible: whether values that the machine can't have are refused; logs may hold such.

    Raises:
        InputError: naming the field: a value without unit, of a wrong kind, not finite, out of range, or after the end;
            a demand outside the stroke, or one that its velocity contradicts.
    """
    sampling, joints = Sampling(cycle, scenario.cycles(cycle)), list(machine.joints)

    def rows_of(name: str) -> Array:
        """Return the values of a signal, (cycles, joints or 1)."""
        row, signal = SIGNALS[name], getattr(scenario, name)
        usual = np.full(len(joints) if row.by_joint else 1, row.usual_of(machine))
        if signal is None and getattr(Scenario, name) is None:
            return np.full((sampling.cycles, len(usual)), np.nan)
        rows = expand_signal(signal, row.kind(name, joints), usual, sampling)
        return row.check(machine, rows, name) if plausible else rows

    demand = _demand(scenario, machine, sampling)
    for j, name in enumerate(joints if scenario.closed_loop else ()):
        worst = float(demand[np.argmax(np.abs(demand[:, j])), j])
        parameters.check_inside_stroke(machine, name, worst, "demand" if scenario.tip is None else "tip")
    found = {"demand": demand}
    for name, moved, rate in (("demand_velocity", "demand", 0), ("demand_acceleration", "demand_velocity", 1)):
        if getattr(scenario, name) is None:
            found[name] = _derived(scenario, found, cycle)[rate]
        else:
            found[name] = rows_of(name)
            if plausible:
                _check_travel(found[name], found[moved], cycle, name)
    found |= {name: rows_of(name) for name in SIGNALS if name not in found}
    by_joint, shared = ([found[name] for name in of._fields] for of in (Acting, Around))
    return Signals(np.stack(by_joint, axis=-1), np.concatenate(shared, axis=-1))


def _demand(scenario: Scenario, machine: Machine, sampling: Sampling) -> Array:
    """Return the demand, (cycles, joints), rad: as given, or angles that bring the tip to where it is asked for."""
    start = start_row(scenario, machine)
    start = np.zeros(len(machine.joints)) if start is None else start
    if scenario.tip is None:
        return expand_signal(scenario.demand, SIGNALS["demand"].kind("demand", list(machine.joints)), start, sampling)
    axes = axes_of(machine)
    places = expand_signal(
        scenario.tip, SignalKind("tip", u.LENGTH, axes, "axis"), tip_position(machine, start), sampling
    )
    return demand_of_tip(machine, places, start, "tip")


def _derived(scenario: Scenario, found: Mapping[str, Array], cycle: float) -> tuple[Array, Array]:
    """Return velocity and acceleration of a demand as it moves on, or as the velocity does that is given."""
    if scenario.demand_velocity is None:
        return derived_rates(found["demand"], cycle)
    return found["demand_velocity"], lasting_rate(found["demand_velocity"], cycle)


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
        InputError: as `expand`; or a voltage stands beside a demand.
    """
    if scenario.voltage is not None and (scenario.asks_for_angles or scenario.tip is not None):
        what = "stands beside a demand, which a run that follows voltages does not"
        raise InputError(what, where="voltage", right="give one or the other")
    found = expand(scenario, machine, cycle)
    own = [value_at(machine, SIGNALS[name].path) for name in Around._fields]
    if machine.valve is not None and scenario.voltage is not None:
        shift = found.named("voltage") - centre_voltage(machine)
        found.named("opening")[:] = shift / machine.valve.volts_to_full
    found.named("voltage")[:] = np.nan
    return Signals(found.by_joint, np.where(np.isnan(found.shared), own, found.shared))


def start_row(scenario: Scenario, machine: Machine) -> Array | None:
    """Return the angles at which the arm rests at first, (joints,), rad; None where the first demand says them.

    Raises:
        InputError: they are no single row of angles, or outside the working stroke.
    """
    if scenario.start is None:
        return None
    kind, given = SignalKind("start", u.ANGLE, list(machine.joints)), scenario.start
    if is_labelled(given):
        given = labelled_row(given, kind)
    if given is None or callable(given) or is_steps(given):
        raise InputError("changes over time", where="start", right='give one row of angles, such as "10 deg"')
    angles = read_row(given, kind, np.zeros(len(kind.names)))
    for name, angle in zip(machine.joints, angles, strict=True):
        parameters.check_inside_stroke(machine, name, float(angle), "start")
    return angles


def start_pressures(scenario: Scenario, machine: Machine) -> Array:
    """Return absolute pressures of hoses A and B at the start, Pa, (joints, 2); nan where none is given.

    Raises:
        InputError: they are no pairs of plausible pressures, or of a joint that is not there.
    """
    kind, given = SignalKind("pressures", u.PRESSURE, list(machine.joints)), scenario.pressures
    pressures = np.full((len(kind.names), 2), np.nan)
    if given is None:
        return pressures
    each = dict(given) if isinstance(given, Mapping) else dict.fromkeys(kind.names, given)
    check_names(each, kind)
    for j, name in enumerate(kind.names):
        if (pair := each.get(name)) is None:
            continue
        if not isinstance(pair, (list, tuple, np.ndarray)) or getattr(pair, "ndim", 1) != 1 or len(pair) != 2:
            right = 'give those of hoses A and B: ("3.5 bar", "3 bar")'
            raise InputError(f"{shown(pair)} is no pair", where="pressures", right=right)
        pressures[j] = [read_number(value, u.PRESSURE, "pressures") for value in pair]
    return HOSE_PRESSURE.check(pressures, "pressures")
