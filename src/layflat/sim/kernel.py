"""The compiled time loop of a run: sense, control, advance, record, one control cycle after the other."""

from typing import Any, NamedTuple

import numpy as np

from layflat.control import wake
from layflat.jit import composition, kernel, law
from layflat.lanes import gather, in_lanes, read_numbers, slots, total, write_row
from layflat.physics.adjustable import FULL
from layflat.physics.chamber import temperature
from layflat.physics.delay import NOTHING_ASKED
from layflat.physics.hysteresis import stored, torques
from layflat.physics.joint import Drive, Joint, Surroundings, is_sound
from layflat.physics.plant import advance, at_rest, together
from layflat.physics.valves import net_opening, start_wave
from layflat.sim.cycle import NOT_LED, NOTHING, NOTHING_AROUND, Loop, Noise, control_cycle, sense_all, surroundings


class Case(NamedTuple):
    """Parameters of a run: tuples of `physics` and `control`."""

    arm: Any
    joints: tuple[Joint, ...]
    settings: Any  # of the control law
    air: Surroundings


class Timing(NamedTuple):
    """Cut of a run: cycle (s), steps of the plant per cycle, records per cycle."""

    cycle: float
    steps: int
    records: int


class Sample(NamedTuple):
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


COLUMNS = len(Sample._fields)


@law
def _sample(joint, state, around, measured_angle, measured_pressure, voltage):
    motion, a, b, ledger = state.motion, state.hose_a, state.hose_b, state.ledger
    loss_a, loss_b, p_a = joint.hose_a.loss, joint.hose_b.loss, around.ambient_pressure
    return Sample(
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
def _record(out, shown, row, joints, states, around, sensed, voltages, report):
    angles, pressures, reports = slots(sensed.angle), slots(sensed.differential_pressure), slots(report)
    for j in range(len(sensed.angle)):
        write_row(out, row, j, _sample(joints[j], states[j], around, angles[j], pressures[j], voltages[j]))
        write_row(shown, row, j, reports[j])


@composition
def _acting(signals, k, j):
    return read_numbers(NOTHING, signals.by_joint[k, j])


@composition
def _noise(samples, k, j):
    return Noise(samples[k, j, 0], samples[k, j, 1])


@composition
def _surroundings(air, signals, k):
    return surroundings(air, read_numbers(NOTHING_AROUND, signals.shared[k]))


@composition
def all_cycles(case, angles, pressures, signals, samples, timing, reported, done):
    """Run all cycles of a scenario from rest.

    Args: `Case`; start angles (joints,) in rad; start pressures (joints, 2) in Pa, nan for those that hold the arm;
    `cycle.Signals`; standard normal samples of the sensors of angle and pressure, (cycles + 1, joints, 2); `Timing`;
    how many signals the law reports of a joint; an array whose first item counts the cycles that are done.
    Returns the records (instants, joints, columns of `Sample`), those of the law's report (instants, joints,
    reported), how many instants are valid, and the joint that diverged (-1: none).
    """
    arm, like, settings, air = case
    cycles, n = len(signals.by_joint), len(like)
    rows = cycles * timing.records + 1
    out, shown = np.empty((rows, n, COLUMNS)), np.empty((rows, n, reported))
    sub, h = timing.steps // timing.records, timing.cycle / timing.steps
    around = _surroundings(air, signals, 0)
    joints = slots(like)
    joined = together(arm, joints)
    firsts, seconds = gather(like, pressures[:, 0]), gather(like, pressures[:, 1])
    states = slots(at_rest(arm, like, gather(like, angles), firsts, seconds, around))
    acting, leads = slots(like, NOTHING), slots(like, NOT_LED)
    noise = slots(like, Noise(0.0, 0.0))
    loop = Loop(
        acting,
        leads,
        noise,
        slots(like, Drive(0.0, 0.0, 0.0, 0.0)),
        slots(like, NOTHING_ASKED),
        slots(like, start_wave(joints[0].valve, 0.0, h)),
        slots(like, 0.0),
        slots(like, FULL),
    )
    sensed = sense_all(joints, like, states, noise)
    memory = in_lanes(wake(settings, sensed), 0.0)
    row = 0
    for k in range(cycles):
        done[0] = k
        around = _surroundings(air, signals, k)
        for j in range(n):
            acting[j], noise[j] = _acting(signals, k, j), _noise(samples, k, j)
        sensed, memory, report = control_cycle(
            joints, like, settings, memory, states, loop, around, timing.cycle * k, timing.cycle, h
        )
        for _ in range(timing.records):
            _record(out, shown, row, joints, states, around, sensed, loop.voltages, report)
            row += 1
            advance(arm, joined, states, loop.drives, loop.waves, around, h, sub)
            for j in range(n):
                if not is_sound(states[j]):
                    return out, shown, row, j
    for j in range(n):
        noise[j] = _noise(samples, cycles, j)
    sensed = sense_all(joints, like, states, noise)
    _record(out, shown, row, joints, states, around, sensed, loop.voltages, report)
    return out, shown, row + 1, -1


@kernel
def run_cycles(like, numbers, angles, pressures, signals, samples, timing, reported, done):
    """Run `all_cycles` of what a case looks like (`Like`) and its numbers in order."""
    return all_cycles(read_numbers(like, numbers), angles, pressures, signals, samples, timing, reported, done)
