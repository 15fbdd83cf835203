"""A scenario as arrays over control cycles, checked against the machine that it acts on."""

from collections.abc import Mapping

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.change import value_at
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine, parameters
from layflat.motion.inverse import solve_tip_demand, tip_axes
from layflat.motion.kinematics import tip_position
from layflat.motion.labelled import is_labelled, read_labelled_row
from layflat.motion.scenario import HOSE_PRESSURE, SIGNALS, Scenario, centre_voltage
from layflat.motion.signal_rows import expand_signal, is_steps
from layflat.motion.signal_values import Sampling, SignalKind, check_names, read_number, read_row
from layflat.motion.trajectory import derived_rates, lasting_rate
from layflat.sim.loop import JointSignals, SharedSignals, Signals

TRAVEL_RATIO, TRAVEL_ROUNDING = 2.0, 1e-3
"""Limit of the travel that a demanded velocity integrates to: ratio to the demand's own travel, and margin (rad)."""

MAX_STEP = 4.0  # step of a demand over the travel that its velocity allows in a cycle; a larger step is a jump


def expand_scenario(scenario: Scenario, machine: Machine, cycle: float, *, plausible: bool = True) -> Signals:
    """Return a scenario as arrays over control cycles; signals that have no default and that it does not set are NaN.

    Rates of the demand that it does not set are derived from the demand.

    Args:
        scenario: signals and disturbances.
        machine: the machine that they act on.
        cycle: control cycle, s.
        plausible: whether to refuse values that are not plausible for the machine; logs may hold such values.

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
    rows = {"demand": demand}
    for name, integral, order in (("demand_velocity", "demand", 0), ("demand_acceleration", "demand_velocity", 1)):
        if getattr(scenario, name) is None:
            rows[name] = _derived_rates(scenario, rows, cycle)[order]
        else:
            rows[name] = rows_of(name)
            if plausible:
                _check_travel(rows[name], rows[integral], cycle, name)
    rows |= {name: rows_of(name) for name in SIGNALS if name not in rows}
    by_joint, shared = ([rows[name] for name in signals._fields] for signals in (JointSignals, SharedSignals))
    return Signals(np.stack(by_joint, axis=-1), np.concatenate(shared, axis=-1))


def _demand(scenario: Scenario, machine: Machine, sampling: Sampling) -> Array:
    """Return the demand, (cycles, joints), rad: as set, or by inverse kinematics from the demanded tip."""
    start = read_start_angles(scenario, machine)
    start = np.zeros(len(machine.joints)) if start is None else start
    if scenario.tip is None:
        return expand_signal(scenario.demand, SIGNALS["demand"].kind("demand", list(machine.joints)), start, sampling)
    axes = tip_axes(machine)
    positions = expand_signal(
        scenario.tip, SignalKind("tip", u.LENGTH, axes, "axis"), tip_position(machine, start), sampling
    )
    return solve_tip_demand(machine, positions, start, "tip")


def _derived_rates(scenario: Scenario, rows: Mapping[str, Array], cycle: float) -> tuple[Array, Array]:
    """Return velocity (rad/s) and acceleration (rad/s2) of a demand, (cycles, joints) each, 0 where it jumps.

    Both are derived from the demand; but a velocity that the scenario sets stays, and the acceleration is derived from
    it.

    Args:
        scenario: scenario with the demand.
        rows: values of "demand" and, if the scenario sets it, of "demand_velocity", (cycles, joints).
        cycle: control cycle, s.
    """
    if scenario.demand_velocity is None:
        return derived_rates(rows["demand"], cycle)
    return rows["demand_velocity"], lasting_rate(rows["demand_velocity"], cycle)


def _check_travel(rate: Array, integral: Array, cycle: float, where: str) -> None:
    """Raise InputError if the rate of a joint, (cycles, joints), integrates to much more travel than `integral` makes.

    `where` names the rate: "demand_velocity" or "demand_acceleration".
    """
    speed = np.abs(rate)
    travel = cycle * speed.sum(axis=0)
    # A jump counts at most the travel that the rate around it allows.
    steps = np.minimum(np.abs(np.diff(integral, axis=0)), MAX_STEP * cycle * np.maximum(speed[:-1], speed[1:]))
    moves = steps.sum(axis=0)
    # The rate of the last cycle has no step of its own.
    excess = travel - (TRAVEL_RATIO * moves + TRAVEL_ROUNDING + cycle * speed.max(axis=0))
    if np.any(excess > 0.0):
        j = int(np.argmax(excess))
        unit, of = ("rad", "the demand") if where == "demand_velocity" else ("rad/s", "its velocity")
        what = f"goes through {travel[j]:.4g} {unit} where {of} changes by {moves[j]:.4g} {unit}"
        raise InputError(what, where=where, right=f"give the rate of {of}, or leave {where} out")


def acting_signals(scenario: Scenario, machine: Machine, cycle: float) -> Signals:
    """Return all signals of a run: the scenario's, and the machine's own values where it sets none.

    A voltage that is set becomes the opening of the valve that it drives; `voltage` is NaN in the result.

    Args:
        scenario: signals and disturbances.
        machine: the machine that they act on.
        cycle: control cycle, s.

    Raises:
        InputError: as `expand_scenario`; or both a voltage and a demand are set.
    """
    if scenario.voltage is not None and (scenario.has_demand or scenario.tip is not None):
        what = "stands beside a demand, which a run that follows voltages does not"
        raise InputError(what, where="voltage", right="give one or the other")
    expanded = expand_scenario(scenario, machine, cycle)
    usual = [value_at(machine, SIGNALS[name].path) for name in SharedSignals._fields]
    if machine.valve is not None and scenario.voltage is not None:
        shift = expanded.named("voltage") - centre_voltage(machine)
        expanded.named("opening")[:] = shift / machine.valve.volts_to_full
    expanded.named("voltage")[:] = np.nan
    return Signals(expanded.by_joint, np.where(np.isnan(expanded.shared), usual, expanded.shared))


def read_start_angles(scenario: Scenario, machine: Machine) -> Array | None:
    """Return the angles at which the arm rests at the start, (joints,), rad; None if the scenario sets none.

    Raises:
        InputError: they are no single row of angles, or outside the working stroke.
    """
    if scenario.start is None:
        return None
    kind, start = SignalKind("start", u.ANGLE, list(machine.joints)), scenario.start
    if is_labelled(start):
        start = read_labelled_row(start, kind)
    if start is None or callable(start) or is_steps(start):
        raise InputError("changes over time", where="start", right='give one row of angles, such as "10 deg"')
    angles = read_row(start, kind, np.zeros(len(kind.names)))
    for name, angle in zip(machine.joints, angles, strict=True):
        parameters.check_inside_stroke(machine, name, float(angle), "start")
    return angles


def start_pressures(scenario: Scenario, machine: Machine) -> Array:
    """Return absolute pressures of hoses A and B at the start, (joints, 2), Pa; NaN where the scenario sets none.

    Raises:
        InputError: they are no pairs of plausible pressures, or name an unknown joint.
    """
    kind, pairs = SignalKind("pressures", u.PRESSURE, list(machine.joints)), scenario.pressures
    pressures = np.full((len(kind.names), 2), np.nan)
    if pairs is None:
        return pressures
    by_joint = dict(pairs) if isinstance(pairs, Mapping) else dict.fromkeys(kind.names, pairs)
    check_names(by_joint, kind)
    for j, name in enumerate(kind.names):
        if (pair := by_joint.get(name)) is None:
            continue
        if not isinstance(pair, (list, tuple, np.ndarray)) or getattr(pair, "ndim", 1) != 1 or len(pair) != 2:
            right = 'give those of hoses A and B: ("3.5 bar", "3 bar")'
            raise InputError(f"{shown(pair)} is no pair", where="pressures", right=right)
        pressures[j] = [read_number(value, u.PRESSURE, "pressures") for value in pair]
    return HOSE_PRESSURE.check(pressures, "pressures")
