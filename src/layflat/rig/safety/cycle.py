"""Control cycle of a rig as compiled code: air balance, detectors, demands, control law and voltages in one call.

Its numbers stay in arrays from call to call (see cycle_numbers.py). The caller selects the stages, since Python decides
between them wherever a fault is detected.
"""

from math import inf, isfinite
from typing import Any, NamedTuple

from layflat.control import Demand, Sensed, centre_shift, step, wake
from layflat.jit import composition, law, portable_kernel
from layflat.lanes import gather, in_lanes, read_numbers, slots, write_numbers
from layflat.physics.air_balance import update_air_estimate
from layflat.physics.arms import dynamics
from layflat.rig.safety import demands, detectors, estimator
from layflat.rig.safety.cycle_numbers import (
    CONTROL_STAGE,
    DEMAND_CHANGED,
    DEMAND_STAGE,
    ESTIMATE_STAGE,
    FAULT_DETECTED,
    GATE_STAGE,
    INPUT_OFFSETS,
    INPUTS_TEMPLATE,
    JOINT_INPUT_OFFSETS,
    JOINT_TEMPLATE,
    JUDGE_STAGE,
    MEMORY_OFFSETS,
    MEMORY_TEMPLATE,
    MODEL_REJECTED,
    RECORDED_WIDTH,
    RIG_TEMPLATE,
    SETTINGS_TEMPLATE,
    VOLTAGE_REFUSED,
    RecordedSignals,
)
from layflat.rig.safety.detectors import bounds, sample
from layflat.rig.safety.estimator import write_holding_torques

MIN_TURNING_SPEED = 0.05  # above which a joint's torque acts on the others; below, its own brake holds it, rad/s
# A cycle that deviates by more than this fraction is uneven; the air is judged again after so long without one, s.
MAX_PERIOD_DEVIATION, MIN_EVEN_TIME = 0.3, 0.1
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
def _write_coupling(arm, rig_numbers, settings, joint_inputs, memory, nothing, scratch):
    """Write each joint's inertia and pressures at rest (see estimator.py) for either payload into `joint_inputs`."""
    n = len(nothing)
    angles, rates = slots(nothing), slots(nothing)
    turns, passive, torques, holding = scratch[0, :n], scratch[1, :n], scratch[2, :n], scratch[3, :n]
    mass, work = scratch[4 : 4 + n, :n], scratch[4 + n :]
    for j in range(n):
        estimate = read_numbers(MEMORY_TEMPLATE, memory[j]).estimate
        angles[j] = (
            joint_inputs[j, JOINT_INPUT_OFFSETS.angle] if isfinite(joint_inputs[j, JOINT_INPUT_OFFSETS.angle]) else 0.0
        )
        # NaN turns nothing.
        turns[j] = (
            1.0 if abs(estimate.averaged_velocity) > MIN_TURNING_SPEED and isfinite(estimate.averaged_pressure) else 0.0
        )
        rates[j] = estimate.averaged_velocity if turns[j] > 0.0 else 0.0
    rig, q, v = read_numbers(RIG_TEMPLATE, rig_numbers), gather(nothing, angles), gather(nothing, rates)
    for heavy in range(2):
        upper, swings, pulls = dynamics(arm, rig.heaviest if heavy else rig.lightest, q, v)
        row, swung, pulled = slots(upper), slots(in_lanes(swings, 0.0)), slots(in_lanes(pulls, 0.0))
        at = 0
        for j in range(n):
            for i in range(j, n):
                mass[j, i] = mass[i, j] = row[at]
                at += 1
            joint = read_numbers(SETTINGS_TEMPLATE, settings[j])
            estimate = read_numbers(MEMORY_TEMPLATE, memory[j]).estimate
            passive[j] = swung[j] + pulled[j]
            friction = 0.5 * joint.detectors.angle_frozen.friction_band * (1.0 if rates[j] > 0.0 else -1.0)
            torques[j] = joint.torque_constant * (estimate.averaged_pressure - friction) + passive[j]
        write_holding_torques(mass, torques, passive, turns, work, holding)
        for j in range(n):
            per = 1.0 / read_numbers(SETTINGS_TEMPLATE, settings[j]).torque_constant
            joint_inputs[j, JOINT_INPUT_OFFSETS.others_light + heavy] = per * holding[j]
            joint_inputs[j, JOINT_INPUT_OFFSETS.inertia] = per * mass[j, j]


@portable_kernel(results=1)
def judge_samples(rig_numbers, settings, inputs, joint_inputs, memory):
    """Update air and detectors by the samples; write faults into `inputs` and `memory`, return FAULT_DETECTED or 0.

    Args: numbers of `RigSettings`, of `JointSettings` (a row a joint, as all that follows but `inputs`), `CycleInputs`,
    `JointInputs` and `JointMemory`.
    """
    n, rig, now = len(settings), read_numbers(RIG_TEMPLATE, rig_numbers), read_numbers(INPUTS_TEMPLATE, inputs)
    without_ripple, lead, worst = 0, 0.0, 0
    for j in range(n):
        before = read_numbers(MEMORY_TEMPLATE, memory[j])
        _, ripple = sample.pressure_oscillation(
            before.detectors.trace, read_numbers(JOINT_TEMPLATE, joint_inputs[j]).pressure
        )
        without_ripple += (
            1 if ripple < read_numbers(SETTINGS_TEMPLATE, settings[j]).detectors.valve_unresponsive.ripple else 0
        )
        lead = max(lead, demands.demand_lead(before.demand))
    # In a late cycle the instants of sampling, and at which the voltage reached its valve, are too uncertain.
    even = 0.0 if abs(now.elapsed - rig.cycle) > MAX_PERIOD_DEVIATION * rig.cycle else now.even + now.elapsed
    trusted = now.supply >= rig.supply.low and even >= MIN_EVEN_TIME
    alone = 1.0 if trusted and (n == 1 or without_ripple < n) else 0.0
    for j in range(n):
        joint, before = read_numbers(SETTINGS_TEMPLATE, settings[j]), read_numbers(MEMORY_TEMPLATE, memory[j])
        samples = read_numbers(JOINT_TEMPLATE, joint_inputs[j])
        opening = _commanded_opening(rig, before)
        air = _update_air(rig, joint, before, samples, opening, now.supply, now.elapsed)
        joint_sample = sample.JointSample(
            samples.angle, samples.pressure, before.estimate.averaged_pressure, samples.others_light,
            samples.others_heavy, samples.inertia, before.estimate.averaged_velocity, opening, air.residual,
            before.demand.demand, lead,
            now.elapsed, now.level, alone,
        )  # fmt: skip
        detected, fault = detectors.find_joint_fault(joint.detectors, before.detectors, joint_sample)
        write_numbers(memory[j, MEMORY_OFFSETS.detectors :], detected)
        write_numbers(memory[j, MEMORY_OFFSETS.air :], air)
        memory[j, MEMORY_OFFSETS.fault] = fault
        worst = max(worst, fault)
    lines, fault = bounds.find_supply(
        rig.supply, now.lines, now.supply, n > 1 and without_ripple == n, now.elapsed, now.level
    )
    write_numbers(inputs[INPUT_OFFSETS.lines :], lines)
    inputs[INPUT_OFFSETS.even], inputs[INPUT_OFFSETS.fault] = even, fault
    return FAULT_DETECTED if worst > 0 or fault > 0 else 0


@composition
def _pass_moving_demands(now, settings, joint_inputs, memory):
    """Pass demands of a control law that plans (see demands.py), with their rates; return DEMAND_CHANGED or 0."""
    changed, turns, jumps = 0, False, False
    for j in range(len(settings)):
        limits = read_numbers(SETTINGS_TEMPLATE, settings[j]).moving
        samples = read_numbers(JOINT_TEMPLATE, joint_inputs[j])
        before = read_numbers(MEMORY_TEMPLATE, memory[j])
        stream = demands.derive_stream(limits, before.stream, samples.requested, now.demand_age, now.since)
        write_numbers(memory[j, MEMORY_OFFSETS.stream :], stream)
        target, _ = demands.extrapolate_demand(
            limits, stream, samples.requested, samples.velocity, samples.acceleration
        )
        turns = turns or demands.reverses_joint(limits, samples.angle, before.estimate.averaged_velocity, target)
        jumps = jumps or demands.is_jump(before.demand.demand, before.velocity, target, now.since)
    for j in range(len(settings)):
        joint, samples = read_numbers(SETTINGS_TEMPLATE, settings[j]), read_numbers(JOINT_TEMPLATE, joint_inputs[j])
        before = read_numbers(MEMORY_TEMPLATE, memory[j])
        after, outcome = demands.MovingDemand(before.demand.demand, 0.0, 0.0), 0
        if now.follow > 0.0 and turns and jumps:
            outcome = demands.DEMAND_LIMITED
        elif now.follow > 0.0:
            target, limited = demands.extrapolate_demand(
                joint.moving, before.stream, samples.requested, samples.velocity, samples.acceleration
            )
            after, outcome = demands.gate_demand(
                joint.moving, before.demand.demand, samples.requested, target, limited, now.since
            )
        reference = demands.advance_reference(
            joint.gate, demands.GatedDemand(after.angle, before.demand.reference), now.since
        )
        write_numbers(memory[j, MEMORY_OFFSETS.demand :], reference)
        memory[j, MEMORY_OFFSETS.velocity], memory[j, MEMORY_OFFSETS.acceleration] = after.velocity, after.acceleration
        memory[j, MEMORY_OFFSETS.outcome] = outcome
        changed = DEMAND_CHANGED if outcome > 0 else changed
    return changed


@composition
def pass_demands(rig_numbers, settings, inputs, joint_inputs, memory):
    """Pass demands through their gates (arguments as of `judge_samples`); return DEMAND_CHANGED if one was, else 0."""
    n, rig, now = len(settings), read_numbers(RIG_TEMPLATE, rig_numbers), read_numbers(INPUTS_TEMPLATE, inputs)
    if rig.plans > 0.0:
        return _pass_moving_demands(now, settings, joint_inputs, memory)
    min_margin, changed = inf, 0
    for j in range(n):
        gate = read_numbers(SETTINGS_TEMPLATE, settings[j]).gate
        before = read_numbers(MEMORY_TEMPLATE, memory[j]).demand
        min_margin = min(
            min_margin, demands.stop_margin(gate, before, read_numbers(JOINT_TEMPLATE, joint_inputs[j]).requested)
        )
    lead = min(rig.demand_step, rig.demand_margin * max(min_margin, 0.0))
    for j in range(n):
        gate = read_numbers(SETTINGS_TEMPLATE, settings[j]).gate
        before = read_numbers(MEMORY_TEMPLATE, memory[j]).demand
        outcome = 0
        if now.follow > 0.0:
            requested = read_numbers(JOINT_TEMPLATE, joint_inputs[j]).requested
            after, outcome = demands.follow_demand(gate, before, requested, lead, now.since)
        else:
            after = demands.advance_reference(gate, before, now.since)
        write_numbers(memory[j, MEMORY_OFFSETS.demand :], after)
        memory[j, MEMORY_OFFSETS.outcome] = outcome
        changed = DEMAND_CHANGED if outcome > 0 else changed
    return changed


@composition
def estimate_motion(settings, inputs, joint_inputs, memory):
    """Write estimates of angle, velocity and pressure into `memory`; arguments as of `judge_samples`."""
    now = read_numbers(INPUTS_TEMPLATE, inputs)
    for j in range(len(settings)):
        samples = read_numbers(JOINT_TEMPLATE, joint_inputs[j])
        before = read_numbers(MEMORY_TEMPLATE, memory[j]).estimator
        if now.wake > 0.0:
            before = estimator.start_estimator(samples.angle, samples.pressure)
        averaged = read_numbers(SETTINGS_TEMPLATE, settings[j]).averaged
        after, estimate = estimator.update_estimate(before, samples.angle, samples.pressure, averaged, now.elapsed)
        write_numbers(memory[j, MEMORY_OFFSETS.estimator :], after)
        write_numbers(memory[j, MEMORY_OFFSETS.estimate :], estimate)


@composition
def pass_voltages(rig_numbers, memory):
    """Write the law's voltages into `voltage`; if one is out of range, centre all, return VOLTAGE_REFUSED, else 0."""
    rig, bad = read_numbers(RIG_TEMPLATE, rig_numbers), 0
    for j in range(len(memory)):
        # The comparison refuses NaN.
        good = rig.voltage_low <= memory[j, MEMORY_OFFSETS.law_voltage] <= rig.voltage_high
        memory[j, MEMORY_OFFSETS.voltage] = memory[j, MEMORY_OFFSETS.law_voltage]
        bad = bad if good else VOLTAGE_REFUSED
    if bad:
        # All of them: a controlled joint and one that is not shake each other.
        for j in range(len(memory)):
            memory[j, MEMORY_OFFSETS.voltage] = rig.centre
    return bad


@portable_kernel()
def write_signals(rows, joint_inputs, memory, report, recorded):
    """Write each joint's signals after a cycle into its part of a row (see `rig.record.RowLayout`), its fault as 0.

    Args: `joint_inputs` and `memory` as of `judge_samples`; the control law's report, a row a joint, and its columns
    that are recorded.
    """
    for j in range(len(rows)):
        samples, after = read_numbers(JOINT_TEMPLATE, joint_inputs[j]), read_numbers(MEMORY_TEMPLATE, memory[j])
        write_numbers(
            rows[j],
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
            rows[j, RECORDED_WIDTH + k] = report[j, recorded[k]]
        rows[j, RECORDED_WIDTH + len(recorded)] = 0.0


class CycleLikes(NamedTuple):
    """Structures of what a cycle reads from arrays."""

    arm: Any
    settings: Any  # of the control law, as the next
    memory: Any


@portable_kernel(results=1)
def run_cycle(
    likes, nothing, rejection_column, rig, settings, inputs, joint_inputs, memory, arm, law_settings, law_memory,
    report, scratch, stages,
):  # fmt: skip
    """Run the stages of a control cycle; return flags of the outcome.

    Args: `CycleLikes`; a tuple of zeros, one a joint; the column of the law's report that is 1 once it has given up its
    model, negative if none; arrays of `CycleCore`; workspace, (2 joints + 4, joints + 1); the stages.
    """
    n = len(nothing)
    flags = 0
    if stages & JUDGE_STAGE:
        _write_coupling(read_numbers(likes.arm, arm), rig, settings, joint_inputs, memory, nothing, scratch)
        flags = judge_samples(rig, settings, inputs, joint_inputs, memory)
        if flags > 0:
            return flags
    if stages & DEMAND_STAGE:
        flags |= pass_demands(rig, settings, inputs, joint_inputs, memory)
    if stages & ESTIMATE_STAGE:
        estimate_motion(settings, inputs, joint_inputs, memory)
    if stages & CONTROL_STAGE:
        now, law_values = read_numbers(INPUTS_TEMPLATE, inputs), read_numbers(likes.settings, law_settings)
        planned = read_numbers(RIG_TEMPLATE, rig).plans
        sensed = Sensed(
            gather(nothing, joint_inputs[:, JOINT_INPUT_OFFSETS.angle]),
            gather(nothing, joint_inputs[:, JOINT_INPUT_OFFSETS.pressure]),
        )
        demand = Demand(
            gather(nothing, memory[:, MEMORY_OFFSETS.demand]), gather(nothing, memory[:, MEMORY_OFFSETS.velocity]),
            gather(nothing, memory[:, MEMORY_OFFSETS.acceleration]), nothing,
        )  # fmt: skip
        before = read_numbers(likes.memory, law_memory)
        if now.wake > 0.0:
            before = in_lanes(wake(law_values, sensed), 0.0)
        cycle_time, elapsed = read_numbers(RIG_TEMPLATE, rig).cycle, now.elapsed
        if planned > 0.0:
            elapsed = min(max(elapsed, MIN_CYCLE_RATIO * cycle_time), MAX_CYCLE_RATIO * cycle_time)
        after, command, signals = step(law_values, before, sensed, demand, elapsed)
        write_numbers(law_memory, in_lanes(after, 0.0))
        voltages, rows = slots(in_lanes(command.voltage, 0.0)), slots(in_lanes(signals, 0.0))
        shifts = slots(in_lanes(centre_shift(law_values, after, nothing), 0.0))
        for j in range(n):
            memory[j, MEMORY_OFFSETS.law_voltage], memory[j, MEMORY_OFFSETS.neutral] = voltages[j], shifts[j]
            write_numbers(report[j], rows[j])
            if rejection_column >= 0 and report[j, rejection_column] > 0.5:
                flags |= MODEL_REJECTED
    if stages & GATE_STAGE:
        flags |= pass_voltages(rig, memory)
    return flags
