"""The compiled run of a machine through a scenario: the time loop with all signals recorded."""

from typing import NamedTuple

import numpy as np

from layflat.jit import composition, law, portable_kernel
from layflat.lanes import gather, read_numbers, slots, total, write_row
from layflat.physics.adjustable import FULL_FRACTIONS
from layflat.physics.chamber import temperature
from layflat.physics.driver import ZERO_COMMANDS
from layflat.physics.hysteresis import stored, torques
from layflat.physics.joint import is_sound
from layflat.physics.plant import states_at_rest
from layflat.physics.valves import net_opening
from layflat.sim.loop import (
    NO_INJECTION,
    ZERO_JOINT_SIGNALS,
    ZERO_NOISE,
    ZERO_SHARED_SIGNALS,
    CycleSpan,
    LoopPorts,
    MachineState,
    Noise,
    Signals,
    initial_memory,
    run_span,
    sense_all,
    surroundings,
)


class RunBuffers(NamedTuple):
    """Inputs of a run over time, and the arrays that its records fill."""

    signals: Signals
    samples: np.ndarray  # standard normal, of the sensors, (cycles + 1, joints, 2)
    out: np.ndarray  # (instants, joints, columns of `JointRecord`)
    reports: np.ndarray  # the control law's report, (instants, joints, signals)
    records: int  # per cycle
    counters: np.ndarray  # control cycles begun, instants recorded, joint that diverged (-1: none)


class JointRecord(NamedTuple):
    """Record of a joint at an instant: the columns of a run, in this order."""

    angle: float
    velocity: float
    pressure_a: float
    pressure_b: float
    temperature_a: float
    temperature_b: float
    valve_opening: float
    voltage: float
    measured_angle: float
    measured_pressure: float
    hose_torque: float
    gas_work: float
    load_work: float
    hose_work: float
    hose_stored: float
    brake_heat: float
    damping_heat: float
    air_taken: float


COLUMNS, VOLTAGE = len(JointRecord._fields), JointRecord._fields.index("voltage")


@law
def joint_record(joint, state, around, measured_angle, measured_pressure, voltage):
    """Return the recorded signals of one joint at an instant."""
    motion, a, b, ledger = state.motion, state.hose_a, state.hose_b, state.ledger
    loss_a, loss_b, p_a = joint.hose_a.loss, joint.hose_b.loss, around.ambient_pressure
    return JointRecord(
        motion.angle,
        motion.velocity,
        a.pressure,
        b.pressure,
        temperature(joint.hose_a.chamber, a.pressure, a.mass, a.volume, p_a),
        temperature(joint.hose_b.chamber, b.pressure, b.mass, b.volume, p_a),
        net_opening(joint.valve, state.valve),
        voltage,
        measured_angle,
        measured_pressure,
        total(torques(loss_a, a.loss) + torques(loss_b, b.loss)),
        ledger.gas_work,
        ledger.load_work,
        ledger.hose_work,
        stored(loss_a, a.loss) + stored(loss_b, b.loss),
        ledger.brake_heat,
        ledger.damping_heat,
        ledger.air_taken,
    )


@composition
def _surroundings(run, air, k):
    return surroundings(air, read_numbers(ZERO_SHARED_SIGNALS, run.signals.shared[k]))


@composition
def _noise(run, k, j):
    return Noise(run.samples[k, j, 0], run.samples[k, j, 1])


@composition
def _observe(run, arm, states, k, cycle):  # noqa: ARG001
    """Store k as the number of cycles begun; return False, so that the run goes on."""
    run.counters[0] = k
    return False


@composition
def _load(run, air, around, acting, noise, k):
    """Write surroundings, signals and noise of control cycle k into their slots."""
    around[0] = _surroundings(run, air, k)
    for j in range(len(acting)):
        acting[j], noise[j] = read_numbers(ZERO_JOINT_SIGNALS, run.signals.by_joint[k, j]), _noise(run, k, j)


@composition
def _write_record(run, joints, states, around, sensed, voltages, report, k, i):
    """Write record i of control cycle k: all joints' signals and reports; update the number of instants recorded."""
    row = k * run.records + i
    angles, pressures, reports = slots(sensed.angle), slots(sensed.differential_pressure), slots(report)
    for j in range(len(sensed.angle)):
        sample = joint_record(joints[j], states[j], around, angles[j], pressures[j], voltages[j])
        write_row(run.out, row, j, sample)
        for instant in range(row, row + 2):  # the last report also holds at the run's end
            write_row(run.reports, instant, j, reports[j])
    run.counters[1] = row + 1


@composition
def _write_last_record(run, machine):
    """Write the signals at the run's end, where the controller's last command also holds."""
    # The controller's last command also holds at the run's end.
    cycles = len(run.signals.by_joint)
    row = cycles * run.records
    joints, states, noise = machine.joints, machine.states, slots(machine.joints, ZERO_NOISE)
    for j in range(len(joints)):
        noise[j] = _noise(run, cycles, j)
    sensed = sense_all(joints, states, noise)
    angles, pressures = slots(sensed.angle), slots(sensed.differential_pressure)
    for j in range(len(joints)):
        voltage = run.out[row - 1, j, VOLTAGE]
        write_row(
            run.out, row, j, joint_record(joints[j], states[j], machine.around[0], angles[j], pressures[j], voltage)
        )
    run.counters[1] = row + 1


@composition
def _has_diverged(run, states, k, i):  # noqa: ARG001
    """Return whether a joint's state has become invalid, and keep the number of the first such joint."""
    for j in range(run.samples.shape[1]):
        if run.counters[2] < 0 and not is_sound(states[j]):
            run.counters[2] = j
    return run.counters[2] >= 0


@composition
def run_case(case, angles, pressures, timing, run):
    """Simulate a `Case` from rest into `RunBuffers`.

    Args: the case; start angles (joints,), rad; start pressures (joints, 2), absolute, Pa, NaN for those that hold the
    arm; `Timing`; the buffers.
    """
    joints, counters = case.joints, run.counters
    counters[0], counters[1], counters[2] = 0, 0, -1
    span = CycleSpan(0, len(run.signals.by_joint))
    around = _surroundings(run, case.air, span.first)
    firsts, seconds = gather(joints, pressures[:, 0]), gather(joints, pressures[:, 1])
    rest = states_at_rest(case.arm, joints, gather(joints, angles), firsts, seconds, around)
    placed, states = slots(joints), slots(rest)
    machine = MachineState(
        case.arm,
        case.settings,
        case.air,
        slots((around,)),
        slots(joints, ZERO_JOINT_SIGNALS),
        placed,
        states,
        slots(joints, ZERO_COMMANDS),
        slots(joints, FULL_FRACTIONS),
        slots(joints, NO_INJECTION),
        slots((initial_memory(case.settings, placed, states),)),
    )
    run_span(machine, span, timing, LoopPorts(_observe, _load, _write_record, _has_diverged), run)
    if counters[2] < 0:
        _write_last_record(run, machine)


@portable_kernel()
def run_cycles(like, numbers, angles, pressures, signals, samples, timing, counters, out, reports):
    """Simulate a scenario from rest.

    Args: `Like` of a `Case`, and its numbers in order; start angles (joints,), rad; start pressures (joints, 2),
    absolute, Pa, NaN for those that hold the arm; `loop.Signals`; standard normal samples of the sensors of angle and
    pressure, (cycles + 1, joints, 2); `Timing`; `RunBuffers.counters`, `RunBuffers.out` and `RunBuffers.reports`, which
    are filled.
    """
    run = RunBuffers(signals, samples, out, reports, timing.records, counters)
    run_case(read_numbers(like, numbers), angles, pressures, timing, run)
