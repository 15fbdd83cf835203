"""A rig's control cycle as compiled code: air balance, detectors, demands, control law and voltages in one call.

Its numbers stay in arrays from call to call (see cycle_numbers.py). The caller says which stages are due, since Python
decides between them wherever anything is found.
"""

from collections.abc import Callable
from math import inf, isfinite
from typing import Any

import numpy as np

from layflat.control import CONTROL_LAWS, Demand, Sensed, centre_shift, step, wake
from layflat.jit import composition, kernel, law
from layflat.lanes import gather, in_lanes, mapped, read_numbers, slots, write_numbers
from layflat.physics.air_balance import follow_air
from layflat.physics.arms import dynamics
from layflat.rig.safety import demands, estimator, moving
from layflat.rig.safety.coupling import torques_at_rest
from layflat.rig.safety.cycle_numbers import (
    BAD,
    CHANGED,
    CONTROL,
    DEMAND,
    DOUBTED,
    ESTIMATE,
    FOUND,
    GATE,
    IN_GIVEN,
    IN_INPUTS,
    IN_MEMORY,
    INPUTS,
    JOINT,
    JUDGE,
    KNOWN,
    MEMORY,
    RIG,
    SETTINGS,
    Known,
)
from layflat.rig.safety.detectors import joint, sample, supply

TURNS = 0.05  # speed from which a joint shakes the others by its torque, which its own brake holds before, rad/s
# A cycle that is longer or shorter by this share is uneven; for so long after it the air is not judged, s.
UNEVEN, CALM = 0.3, 0.1
# Cycles that a law which plans its motion takes for one at least, and at most: it steps its model by the time.
SHORTEST, LONGEST = 0.5, 2.0


@law
def _opening(rig, memory):
    """Opening that the valve was last asked for."""
    return (memory.voltage - (memory.neutral + rig.centre)) * rig.per_volt


@law
def _air(rig, settings, memory, came, opening, supply_pressure, elapsed):
    """Return what is known of the air after this cycle; where something is not a number, what was before."""
    if not (isfinite(came.angle) and isfinite(came.pressure) and isfinite(supply_pressure)):
        return memory.air
    return follow_air(
        settings.air, memory.air, opening, came.angle, came.pressure, supply_pressure, rig.ambient, elapsed
    )


@composition
def _couple(arm, rig_numbers, settings, given, memory, nothing):
    """Write what gravity and joints that turn ask of each joint (see coupling.py), with either end of the payload."""
    n = len(nothing)
    angles, rates = slots(nothing), slots(nothing)
    turns, mass, work = np.zeros(n), np.empty((n, n)), np.empty((n, n + 1))
    for j in range(n):
        seen = read_numbers(MEMORY, memory[j]).estimate
        angles[j] = given[j, IN_GIVEN.angle] if isfinite(given[j, IN_GIVEN.angle]) else 0.0
        # What is not a number turns nothing.
        turns[j] = 1.0 if abs(seen.averaged_velocity) > TURNS and isfinite(seen.averaged_pressure) else 0.0
        rates[j] = seen.averaged_velocity if turns[j] > 0.0 else 0.0
    rig, q, v = read_numbers(RIG, rig_numbers), gather(nothing, angles), gather(nothing, rates)
    passive, torques, asked = np.empty(n), np.empty(n), np.empty(n)
    for heavy in range(2):
        upper, swings, pulls = dynamics(arm, rig.heaviest if heavy else rig.lightest, q, v)
        row, swung, pulled = slots(upper), slots(in_lanes(swings, 0.0)), slots(in_lanes(pulls, 0.0))
        at = 0
        for j in range(n):
            for i in range(j, n):
                mass[j, i] = mass[i, j] = row[at]
                at += 1
            own, seen = read_numbers(SETTINGS, settings[j]), read_numbers(MEMORY, memory[j]).estimate
            passive[j] = swung[j] + pulled[j]
            rubs = 0.5 * own.detectors.angle_frozen.friction_band * (1.0 if rates[j] > 0.0 else -1.0)
            torques[j] = own.torque_constant * (seen.averaged_pressure - rubs) + passive[j]
        torques_at_rest(mass, torques, passive, turns, work, asked)
        for j in range(n):
            per = 1.0 / read_numbers(SETTINGS, settings[j]).torque_constant
            given[j, IN_GIVEN.others_light + heavy] = per * asked[j]
            given[j, IN_GIVEN.inertia] = per * mass[j, j]


@kernel
def judge(rig_numbers, settings, inputs, given, memory):
    """Run all detectors on what was sampled; writes faults into `inputs` and `memory`, and returns FOUND or 0.

    Args: numbers of a `Rig`, of `Settings` (a row a joint, as all that follows but `inputs`), `Inputs`, `JointInputs`
    and `Memory`.
    """
    n, rig, now = len(settings), read_numbers(RIG, rig_numbers), read_numbers(INPUTS, inputs)
    still, lead, worst = 0, 0.0, 0
    for j in range(n):
        before = read_numbers(MEMORY, memory[j])
        _, ripple = sample.swung(before.detectors.trace, read_numbers(JOINT, given[j]).pressure)
        still += 1 if ripple < read_numbers(SETTINGS, settings[j]).detectors.valve_unresponsive.ripple else 0
        lead = max(lead, demands.ahead(before.demand))
    # When a late cycle's voltage reached its valve, and when it was sampled, is not known well enough.
    even = 0.0 if abs(now.elapsed - rig.cycle) > UNEVEN * rig.cycle else now.even + now.elapsed
    trusted = now.supply >= rig.supply.low and even >= CALM
    alone = 1.0 if trusted and (n == 1 or still < n) else 0.0
    for j in range(n):
        own, before = read_numbers(SETTINGS, settings[j]), read_numbers(MEMORY, memory[j])
        came = read_numbers(JOINT, given[j])
        opening = _opening(rig, before)
        air = _air(rig, own, before, came, opening, now.supply, now.elapsed)
        taken = sample.Sample(
            came.angle, came.pressure, before.estimate.averaged_pressure, came.others_light, came.others_heavy,
            came.inertia, before.estimate.averaged_velocity, opening, air.residual, before.demand.demand, lead,
            now.elapsed, now.level, alone,
        )  # fmt: skip
        detectors, fault = joint.find(own.detectors, before.detectors, taken)
        write_numbers(memory[j, IN_MEMORY.detectors :], detectors)
        write_numbers(memory[j, IN_MEMORY.air :], air)
        memory[j, IN_MEMORY.fault] = fault
        worst = max(worst, fault)
    lines, fault = supply.find(rig.supply, now.lines, now.supply, n > 1 and still == n, now.elapsed, now.level)
    write_numbers(inputs[IN_INPUTS.lines :], lines)
    inputs[IN_INPUTS.even], inputs[IN_INPUTS.fault] = even, fault
    return FOUND if worst > 0 or fault > 0 else 0


@kernel
def _let_move(now, settings, given, memory):
    """Pass demands of a control law that plans (see moving.py), with their rates; returns CHANGED or 0."""
    changed, turns, jumps = 0, False, False
    for j in range(len(settings)):
        own, came = read_numbers(SETTINGS, settings[j]).moving, read_numbers(JOINT, given[j])
        before = read_numbers(MEMORY, memory[j])
        stream = moving.derived(own, before.stream, came.asked, now.meant, now.since)
        write_numbers(memory[j, IN_MEMORY.stream :], stream)
        where, _ = moving.by_now(own, stream, came.asked, came.velocity, came.acceleration)
        turns = turns or moving.turns(own, came.angle, before.estimate.averaged_velocity, where)
        jumps = jumps or moving.jumps(before.demand.demand, before.velocity, where, now.since)
    for j in range(len(settings)):
        own, came = read_numbers(SETTINGS, settings[j]), read_numbers(JOINT, given[j])
        before = read_numbers(MEMORY, memory[j])
        after, outcome = moving.Moving(before.demand.demand, 0.0, 0.0), 0
        if now.follow > 0.0 and turns and jumps:
            outcome = demands.LIMITED
        elif now.follow > 0.0:
            where, limited = moving.by_now(own.moving, before.stream, came.asked, came.velocity, came.acceleration)
            after, outcome = moving.let_through(own.moving, before.demand.demand, came.asked, where, limited, now.since)
        reference = demands.settled(own.gate, demands.Demand(after.angle, before.demand.reference), now.since)
        write_numbers(memory[j, IN_MEMORY.demand :], reference)
        memory[j, IN_MEMORY.velocity], memory[j, IN_MEMORY.acceleration] = after.velocity, after.acceleration
        memory[j, IN_MEMORY.outcome] = outcome
        changed = CHANGED if outcome > 0 else changed
    return changed


@kernel
def let_through(rig_numbers, settings, inputs, given, memory):
    """Pass demands through their gates (arguments as of `judge`); returns CHANGED where one was, else 0."""
    n, rig, now = len(settings), read_numbers(RIG, rig_numbers), read_numbers(INPUTS, inputs)
    if rig.plans > 0.0:
        return _let_move(now, settings, given, memory)
    least, changed = inf, 0
    for j in range(n):
        gate, before = read_numbers(SETTINGS, settings[j]).gate, read_numbers(MEMORY, memory[j]).demand
        least = min(least, demands.margin(gate, before, read_numbers(JOINT, given[j]).asked))
    lead = min(rig.demand_lead, rig.demand_margin * max(least, 0.0))
    for j in range(n):
        gate, before = read_numbers(SETTINGS, settings[j]).gate, read_numbers(MEMORY, memory[j]).demand
        outcome = 0
        if now.follow > 0.0:
            asked = read_numbers(JOINT, given[j]).asked
            after, outcome = demands.followed(gate, before, asked, lead, now.since)
        else:
            after = demands.settled(gate, before, now.since)
        write_numbers(memory[j, IN_MEMORY.demand :], after)
        memory[j, IN_MEMORY.outcome] = outcome
        changed = CHANGED if outcome > 0 else changed
    return changed


@kernel
def estimate(settings, inputs, given, memory):
    """Estimate angles, velocities and pressures from what was sampled; arguments as of `judge`."""
    now = read_numbers(INPUTS, inputs)
    for j in range(len(settings)):
        came, before = read_numbers(JOINT, given[j]), read_numbers(MEMORY, memory[j]).estimator
        if now.wake > 0.0:
            before = estimator.woken(came.angle, came.pressure)
        averaged = read_numbers(SETTINGS, settings[j]).averaged
        after, found = estimator.estimated(before, came.angle, came.pressure, averaged, now.elapsed)
        write_numbers(memory[j, IN_MEMORY.estimator :], after)
        write_numbers(memory[j, IN_MEMORY.estimate :], found)


@kernel
def gate(rig_numbers, memory):
    """Pass voltages that may be sent; returns BAD where one may not, and all valves are centred then."""
    rig, bad = read_numbers(RIG, rig_numbers), 0
    for j in range(len(memory)):
        # Written so that what is not a number is refused.
        good = rig.voltage_low <= memory[j, IN_MEMORY.asked] <= rig.voltage_high
        memory[j, IN_MEMORY.voltage] = memory[j, IN_MEMORY.asked]
        bad = bad if good else BAD
    if bad:
        # All of them: a joint that is held by its controller is shaken by one that is not, and shakes it.
        for j in range(len(memory)):
            memory[j, IN_MEMORY.voltage] = rig.centre
    return bad


@kernel
def record(rows, given, memory, report, recorded):
    """Write what is known of each joint after a cycle into its part of a row (see `rig.record.Layout`), without faults.

    Args: `given` and `memory` as of `judge`; what the control law reports, a row a joint, and which columns of it are
    recorded.
    """
    for j in range(len(rows)):
        came, after = read_numbers(JOINT, given[j]), read_numbers(MEMORY, memory[j])
        write_numbers(
            rows[j],
            Known(
                after.demand.demand,
                after.velocity,
                after.voltage,
                came.angle,
                came.pressure,
                after.estimate,
                after.air.taken,
            ),
        )
        for k in range(len(recorded)):
            rows[j, KNOWN + k] = report[j, recorded[k]]
        rows[j, KNOWN + len(recorded)] = 0.0


_known: dict[str, Callable[..., int]] = {}


def cycle_with(arm: Any, settings: Any, memory: Any, joints: int) -> Callable[..., int]:
    """The cycle of an arm with a control law (see `_cycle`); arm, settings and memory of the law are such tuples.

    With a law that is plain Python this is Python too, but for what the rig itself does.
    """
    arm, settings, memory = (mapped(like, lambda _: 0.0) for like in (arm, settings, memory))
    # By text: tuples of different classes are equal where their items are.
    kind = repr((arm, settings, memory, joints))
    if kind not in _known:
        law_kind = CONTROL_LAWS.of(settings)
        doubts = list(law_kind.signals).index(law_kind.gives_up) if law_kind.gives_up is not None else -1
        cycle = _cycle(arm, settings, memory, (0.0,) * joints, doubts)
        performed = "dispatcher" if law_kind.compiled else "py_func"
        _known[kind] = getattr(cycle, performed, cycle)
    return _known[kind]


def _cycle(arm_like, settings_like, memory_like, nothing, doubts):
    # doubts: column of the law's report that says whether it gave up; below zero: none.
    n = len(nothing)

    @kernel
    def cycle(rig, settings, inputs, given, memory, arm, law_settings, law_memory, report, stages):
        came = 0
        if stages & JUDGE:
            _couple(read_numbers(arm_like, arm), rig, settings, given, memory, nothing)
            came = judge(rig, settings, inputs, given, memory)
            if came > 0:
                return came
        if stages & DEMAND:
            came |= let_through(rig, settings, inputs, given, memory)
        if stages & ESTIMATE:
            estimate(settings, inputs, given, memory)
        if stages & CONTROL:
            now, own = read_numbers(INPUTS, inputs), read_numbers(settings_like, law_settings)
            planned = read_numbers(RIG, rig).plans
            sensed = Sensed(gather(nothing, given[:, IN_GIVEN.angle]), gather(nothing, given[:, IN_GIVEN.pressure]))
            demand = Demand(
                gather(nothing, memory[:, IN_MEMORY.demand]), gather(nothing, memory[:, IN_MEMORY.velocity]),
                gather(nothing, memory[:, IN_MEMORY.acceleration]), nothing,
            )  # fmt: skip
            before = read_numbers(memory_like, law_memory)
            if now.wake > 0.0:
                before = in_lanes(wake(own, sensed), 0.0)
            cycle_time, elapsed = read_numbers(RIG, rig).cycle, now.elapsed
            if planned > 0.0:
                elapsed = min(max(elapsed, SHORTEST * cycle_time), LONGEST * cycle_time)
            after, command, signals = step(own, before, sensed, demand, elapsed)
            write_numbers(law_memory, in_lanes(after, 0.0))
            voltages, rows = slots(in_lanes(command.voltage, 0.0)), slots(in_lanes(signals, 0.0))
            shifts = slots(in_lanes(centre_shift(own, after, nothing), 0.0))
            for j in range(n):
                memory[j, IN_MEMORY.asked], memory[j, IN_MEMORY.neutral] = voltages[j], shifts[j]
                write_numbers(report[j], rows[j])
                if doubts >= 0 and report[j, doubts] > 0.5:
                    came |= DOUBTED
        if stages & GATE:
            came |= gate(rig, memory)
        return came

    return cycle
