"""Stages of a rig's control cycle as compiled code: air balance, detectors, demands, control law and voltages.

Their numbers stay in arrays from call to call: most functions take `CycleRows` (see cycle_numbers.py).
"""

# mypy: disable-error-code="no-untyped-def"

from math import inf, isfinite
from typing import Any, NamedTuple

from layflat.control import Demand, Sensed, centre_shift, step, wake
from layflat.jit import composition, law, portable_kernel
from layflat.lanes import gather, in_lanes, read_numbers, slots, write_numbers
from layflat.physics.air_balance import update_air_estimate
from layflat.physics.arms import dynamics
from layflat.rig.safety import demands, detectors, estimator
from layflat.rig.safety.cycle_numbers import (
    FIRST_JOINT_MEMORY,
    FIRST_MEMORY,
    INPUTS_TEMPLATE,
    JOINT_AT,
    JOINT_INPUTS_TEMPLATE,
    LIMIT_AT,
    MIN_EVEN_TIME,
    RECORDED_WIDTH,
    RIG_AT,
    RIG_TEMPLATE,
    SAMPLE_AT,
    SETTING_AT,
    SETTINGS_TEMPLATE,
    RecordedSignals,
)
from layflat.rig.safety.detectors import bounds, sample
from layflat.rig.safety.estimator import write_holding_torques
from layflat.rig.safety.faults import MODE_NO

MIN_TURNING_SPEED = 0.05  # above which a joint's torque acts on the others; below, its own brake holds it, rad/s
MAX_PERIOD_DEVIATION = 0.3  # fraction; a cycle that deviates by more is uneven, and the air is not judged
# Limits, in cycles, of the time by which a law that plans its motion steps its model.
MIN_CYCLE_RATIO, MAX_CYCLE_RATIO = 0.5, 2.0


@law
def _commanded_opening(rig, memory):
    """Return the last commanded opening of the valve, -1..1, from its estimated neutral voltage."""
    return (memory.voltage - (memory.neutral + rig.centre)) * rig.per_volt


@law
def _update_air(rig, settings, memory, samples, opening, supply_pressure, elapsed):
    """Return the estimate of the air after this cycle; the one before where an input is not finite."""
    if not (isfinite(samples.angle) and isfinite(samples.pressure) and isfinite(supply_pressure)):
        return memory.air
    return update_air_estimate(
        settings.air, memory.air, opening, samples.angle, samples.pressure, supply_pressure, rig.ambient, elapsed
    )


@composition
def write_coupling(rows, arm, nothing, scratch):
    """Write each joint's inertia and pressures at rest (see estimator.py) for either payload into its memory.

    Args: `CycleRows`; parameters of the arm; a tuple of zeros, one a joint; workspace, (2 joints + 4, joints + 1).
    """
    n = len(nothing)
    angles, rates = slots(nothing), slots(nothing)
    turns, passive, torques, holding = scratch[0, :n], scratch[1, :n], scratch[2, :n], scratch[3, :n]
    mass, work = scratch[4 : 4 + n, :n], scratch[4 + n :]
    for j in range(n):
        estimate = read_numbers(FIRST_JOINT_MEMORY.estimate, rows.joints[j, JOINT_AT.estimate :])
        angles[j] = rows.samples[j, SAMPLE_AT.angle] if isfinite(rows.samples[j, SAMPLE_AT.angle]) else 0.0
        # NaN turns nothing.
        turns[j] = (
            1.0 if abs(estimate.averaged_velocity) > MIN_TURNING_SPEED and isfinite(estimate.averaged_pressure) else 0.0
        )
        rates[j] = estimate.averaged_velocity if turns[j] > 0.0 else 0.0
    rig, q, v = read_numbers(RIG_TEMPLATE, rows.rig), gather(nothing, angles), gather(nothing, rates)
    for heavy in range(2):
        upper, swings, pulls = dynamics(arm, rig.heaviest if heavy else rig.lightest, q, v)
        row, swung, pulled = slots(upper), slots(in_lanes(swings, 0.0)), slots(in_lanes(pulls, 0.0))
        at = 0
        for j in range(n):
            for i in range(j, n):
                mass[j, i] = mass[i, j] = row[at]
                at += 1
            joint = read_numbers(SETTINGS_TEMPLATE, rows.settings[j])
            estimate = read_numbers(FIRST_JOINT_MEMORY.estimate, rows.joints[j, JOINT_AT.estimate :])
            passive[j] = swung[j] + pulled[j]
            friction = 0.5 * joint.detectors.angle_frozen.friction_band * (1.0 if rates[j] > 0.0 else -1.0)
            torques[j] = joint.torque_constant * (estimate.averaged_pressure - friction) + passive[j]
        write_holding_torques(mass, torques, passive, turns, work, holding)
        for j in range(n):
            per = 1.0 / rows.settings[j, SETTING_AT.torque_constant]
            rows.joints[j, JOINT_AT.others_light + heavy] = per * holding[j]
            rows.joints[j, JOINT_AT.inertia] = per * mass[j, j]


@portable_kernel()
def judge_samples(rows, level):
    """Update air and detectors by the samples, and write the faults that they show into the memory.

    Args: `CycleRows`; the level of detection (see detectors/sample.py).
    """
    n, rig, now = len(rows.settings), read_numbers(RIG_TEMPLATE, rows.rig), read_numbers(INPUTS_TEMPLATE, rows.inputs)
    machine, without_ripple, lead = read_numbers(FIRST_MEMORY, rows.memory), 0, 0.0
    for j in range(n):
        before = read_numbers(FIRST_JOINT_MEMORY, rows.joints[j])
        _, ripple = sample.pressure_oscillation(before.detectors.trace, rows.samples[j, SAMPLE_AT.pressure])
        without_ripple += (
            1 if ripple < read_numbers(SETTINGS_TEMPLATE, rows.settings[j]).detectors.valve_unresponsive.ripple else 0
        )
        lead = max(lead, demands.demand_lead(before.demand))
    # In a late cycle the instants of sampling, and at which the voltage reached its valve, are too uncertain.
    even = 0.0 if abs(now.elapsed - rig.cycle) > MAX_PERIOD_DEVIATION * rig.cycle else machine.even + now.elapsed
    trusted = now.supply >= rig.supply.low and even >= MIN_EVEN_TIME
    alone = 1.0 if trusted and (n == 1 or without_ripple < n) else 0.0
    for j in range(n):
        joint = read_numbers(SETTINGS_TEMPLATE, rows.settings[j])
        before = read_numbers(FIRST_JOINT_MEMORY, rows.joints[j])
        samples = read_numbers(JOINT_INPUTS_TEMPLATE, rows.samples[j])
        opening = _commanded_opening(rig, before)
        air = _update_air(rig, joint, before, samples, opening, now.supply, now.elapsed)
        joint_sample = sample.JointSample(
            samples.angle, samples.pressure, before.estimate.averaged_pressure, before.others_light,
            before.others_heavy, before.inertia, before.estimate.averaged_velocity, opening, air.residual,
            before.demand.demand, lead,
            now.elapsed, level, alone,
        )  # fmt: skip
        detected, fault = detectors.find_joint_fault(joint.detectors, before.detectors, joint_sample)
        write_numbers(rows.joints[j, JOINT_AT.detectors :], detected)
        write_numbers(rows.joints[j, JOINT_AT.air :], air)
        rows.joints[j, JOINT_AT.fault] = fault
    lines, fault = bounds.find_supply(
        rig.supply, machine.lines, now.supply, n > 1 and without_ripple == n, now.elapsed, level
    )
    write_numbers(rows.memory[RIG_AT.lines :], lines)
    rows.memory[RIG_AT.even], rows.memory[RIG_AT.fault] = even, fault


@composition
def _pass_moving_demands(rows, now, is_followed):
    """Pass demands of a control law that plans (see demands.py), with their rates."""
    turns, jumps = False, False
    for j in range(len(rows.settings)):
        limits = read_numbers(SETTINGS_TEMPLATE.moving, rows.settings[j, SETTING_AT.moving :])
        samples = read_numbers(JOINT_INPUTS_TEMPLATE, rows.samples[j])
        before = read_numbers(FIRST_JOINT_MEMORY, rows.joints[j])
        stream = demands.derive_stream(limits, before.stream, samples.requested, now.demand_age, now.since)
        write_numbers(rows.joints[j, JOINT_AT.stream :], stream)
        target, _ = demands.extrapolate_demand(
            limits, stream, samples.requested, samples.velocity, samples.acceleration
        )
        turns = turns or demands.reverses_joint(limits, samples.angle, before.estimate.averaged_velocity, target)
        jumps = jumps or demands.is_jump(before.demand.demand, before.velocity, target, now.since)
    for j in range(len(rows.settings)):
        joint = read_numbers(SETTINGS_TEMPLATE, rows.settings[j])
        samples = read_numbers(JOINT_INPUTS_TEMPLATE, rows.samples[j])
        before = read_numbers(FIRST_JOINT_MEMORY, rows.joints[j])
        after, outcome = demands.MovingDemand(before.demand.demand, 0.0, 0.0), 0
        if is_followed and turns and jumps:
            outcome = demands.DEMAND_LIMITED
        elif is_followed:
            target, limited = demands.extrapolate_demand(
                joint.moving, before.stream, samples.requested, samples.velocity, samples.acceleration
            )
            after, outcome = demands.gate_demand(
                joint.moving, before.demand.demand, samples.requested, target, limited, now.since
            )
        reference = demands.advance_reference(
            joint.gate, demands.GatedDemand(after.angle, before.demand.reference), now.since
        )
        write_numbers(rows.joints[j, JOINT_AT.demand :], reference)
        rows.joints[j, JOINT_AT.velocity], rows.joints[j, JOINT_AT.acceleration] = after.velocity, after.acceleration
        rows.joints[j, JOINT_AT.outcome] = outcome


@composition
def pass_demands(rows):
    """Pass demands through their gates."""
    n, rig, now = len(rows.settings), read_numbers(RIG_TEMPLATE, rows.rig), read_numbers(INPUTS_TEMPLATE, rows.inputs)
    is_followed = rows.memory[RIG_AT.mode] == MODE_NO.FOLLOW
    if rig.plans > 0.0:
        _pass_moving_demands(rows, now, is_followed)
        return
    min_margin = inf
    for j in range(n):
        gate = read_numbers(SETTINGS_TEMPLATE.gate, rows.settings[j, SETTING_AT.gate :])
        before = read_numbers(FIRST_JOINT_MEMORY.demand, rows.joints[j, JOINT_AT.demand :])
        min_margin = min(min_margin, demands.stop_margin(gate, before, rows.samples[j, SAMPLE_AT.requested]))
    lead = min(rig.demand_step, rig.demand_margin * max(min_margin, 0.0))
    for j in range(n):
        gate = read_numbers(SETTINGS_TEMPLATE.gate, rows.settings[j, SETTING_AT.gate :])
        before = read_numbers(FIRST_JOINT_MEMORY.demand, rows.joints[j, JOINT_AT.demand :])
        outcome = 0
        if is_followed:
            after, outcome = demands.follow_demand(gate, before, rows.samples[j, SAMPLE_AT.requested], lead, now.since)
        else:
            after = demands.advance_reference(gate, before, now.since)
        write_numbers(rows.joints[j, JOINT_AT.demand :], after)
        rows.joints[j, JOINT_AT.outcome] = outcome


@composition
def estimate_motion(rows):
    """Write estimates of angle, velocity and pressure into the memory."""
    elapsed = read_numbers(INPUTS_TEMPLATE, rows.inputs).elapsed
    for j in range(len(rows.settings)):
        samples = read_numbers(JOINT_INPUTS_TEMPLATE, rows.samples[j])
        before = read_numbers(FIRST_JOINT_MEMORY.estimator, rows.joints[j, JOINT_AT.estimator :])
        if rows.memory[RIG_AT.wake] > 0.0:
            before = estimator.start_estimator(samples.angle, samples.pressure)
        averaged = rows.settings[j, SETTING_AT.averaged]
        after, estimate = estimator.update_estimate(before, samples.angle, samples.pressure, averaged, elapsed)
        write_numbers(rows.joints[j, JOINT_AT.estimator :], after)
        write_numbers(rows.joints[j, JOINT_AT.estimate :], estimate)


class CycleLikes(NamedTuple):
    """Structures of what a cycle reads from arrays."""

    arm: Any
    settings: Any  # of the control law, as the next
    memory: Any


@composition
def run_law(rows, likes, law_rows, nothing, rejection_column):
    """Run the control law; write its voltages and reports, and whether it has given up its model.

    Args: `CycleRows`, `CycleLikes`, `LawRows`; a tuple of zeros, one a joint; the column of the law's report that is 1
    once it has given up its model, negative if none.
    """
    rig, law_values = read_numbers(RIG_TEMPLATE, rows.rig), read_numbers(likes.settings, law_rows.settings)
    sensed = Sensed(
        gather(nothing, rows.samples[:, SAMPLE_AT.angle]), gather(nothing, rows.samples[:, SAMPLE_AT.pressure])
    )
    demand = Demand(
        gather(nothing, rows.joints[:, JOINT_AT.demand]), gather(nothing, rows.joints[:, JOINT_AT.velocity]),
        gather(nothing, rows.joints[:, JOINT_AT.acceleration]), nothing,
    )  # fmt: skip
    before = read_numbers(likes.memory, law_rows.memory)
    if rows.memory[RIG_AT.wake] > 0.0:
        before = in_lanes(wake(law_values, sensed), 0.0)
    elapsed = read_numbers(INPUTS_TEMPLATE, rows.inputs).elapsed
    if rig.plans > 0.0:
        elapsed = min(max(elapsed, MIN_CYCLE_RATIO * rig.cycle), MAX_CYCLE_RATIO * rig.cycle)
    after, command, signals = step(law_values, before, sensed, demand, elapsed)
    write_numbers(law_rows.memory, in_lanes(after, 0.0))
    voltages, reports = slots(in_lanes(command.voltage, 0.0)), slots(in_lanes(signals, 0.0))
    shifts = slots(in_lanes(centre_shift(law_values, after, nothing), 0.0))
    for j in range(len(nothing)):
        rows.joints[j, JOINT_AT.law_voltage], rows.joints[j, JOINT_AT.neutral] = voltages[j], shifts[j]
        write_numbers(law_rows.report[j], reports[j])
        if rejection_column >= 0 and law_rows.report[j, rejection_column] > 0.5:
            rows.memory[RIG_AT.rejected] = 1.0
    rows.memory[RIG_AT.wake] = 0.0


@composition
def is_voltage_good(rows, j):
    """Return whether the law's voltage of a joint is a number in range."""
    return rows.rig[LIMIT_AT.voltage_low] <= rows.joints[j, JOINT_AT.law_voltage] <= rows.rig[LIMIT_AT.voltage_high]


@composition
def pass_voltages(rows):
    """Pass the law's voltages; if one is out of range, centre all, and write that they were refused."""
    n = len(rows.joints)
    for j in range(n):
        rows.joints[j, JOINT_AT.voltage] = rows.joints[j, JOINT_AT.law_voltage]
        if not is_voltage_good(rows, j):
            rows.memory[RIG_AT.refused] = 1.0
    if rows.memory[RIG_AT.refused] > 0.0:
        # All of them: a controlled joint and one that is not shake each other.
        for j in range(n):
            rows.joints[j, JOINT_AT.voltage] = rows.rig[LIMIT_AT.centre]


@portable_kernel()
def write_signals(signals, rows, report, recorded):
    """Write each joint's signals after a cycle into its part of a row (see `rig.record.RowLayout`).

    Args: the row; `CycleRows`; the control law's report, a row a joint, and its columns that are recorded.
    """
    for j in range(len(signals)):
        samples = read_numbers(JOINT_INPUTS_TEMPLATE, rows.samples[j])
        after = read_numbers(FIRST_JOINT_MEMORY, rows.joints[j])
        write_numbers(
            signals[j],
            RecordedSignals(
                after.demand.demand,
                after.velocity,
                after.voltage,
                samples.angle,
                samples.pressure,
                after.estimate,
                after.air.taken,
            ),
        )
        for k in range(len(recorded)):
            signals[j, RECORDED_WIDTH + k] = report[j, recorded[k]]
        signals[j, RECORDED_WIDTH + len(recorded)] = max(after.latched, after.worst_now)
