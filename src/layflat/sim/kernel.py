"""The compiled time loop of a run: sense, control, advance, record, one control cycle after the other."""

from typing import NamedTuple

import numpy as np

from layflat.control.controller import start, step
from layflat.control.gains import Measurement, Status
from layflat.jit import kernel, law
from layflat.lanes import write_row
from layflat.physics.chamber import temperature
from layflat.physics.delay import NOTHING_ASKED
from layflat.physics.joint import Drive, Surroundings, is_sound, joint_at_rest
from layflat.physics.loss import stored_energy
from layflat.physics.plant import advance
from layflat.physics.sensor import read_sensor
from layflat.physics.valve import driven, net_opening, start_wave


class Timing(NamedTuple):
    """How a run is cut: cycle (s), steps of the plant per cycle, records per cycle, 1 if the controller drives."""

    cycle: float
    steps: int
    records: int
    closed_loop: bool


class Signals(NamedTuple):
    """What acts on the machine, an item per cycle (first axis) and, where shaped so, per joint (second axis)."""

    demand: np.ndarray
    """rad, (cycles, joints)"""
    opening: np.ndarray
    """Valve opening in an open-loop run, -1..1, (cycles, joints)"""
    brake: np.ndarray
    """Torque at which the brake slips, N m, (cycles, joints)"""
    load: np.ndarray
    """External torque, N m, (cycles, joints)"""
    drift: np.ndarray
    """Shift of the valve's centre, V, (cycles, joints)"""
    supply: np.ndarray
    """Absolute supply pressure, Pa, (cycles,)"""
    payload: np.ndarray
    """kg, (cycles,)"""
    noise: np.ndarray
    """Standard normal samples of angle and pressure sensor, (cycles + 1, joints, 2)"""


class Sample(NamedTuple):
    """What is recorded of a joint at an instant: the columns of a run, in this order."""

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
    averaged_angle: float
    averaged_velocity: float
    averaged_pressure: float
    ripple: float
    phase: float
    short_term: float
    long_term: float
    learning: float
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
def _sample(joint, state, around, measured, voltage, memory, status):
    motion, a, b, ledger = state.motion, state.hose_a, state.hose_b, state.ledger
    loss_a, loss_b = joint.hose_a.loss, joint.hose_b.loss
    p_a = around.ambient_pressure
    return Sample(
        motion.angle,
        motion.velocity,
        a.pressure,
        b.pressure,
        temperature(joint.hose_a.chamber, a.pressure, a.mass, a.volume, p_a),
        temperature(joint.hose_b.chamber, b.pressure, b.mass, b.volume, p_a),
        net_opening(state.valve),
        voltage,
        measured.angle,
        measured.differential_pressure,
        status.angle,
        status.velocity,
        status.differential_pressure,
        status.ripple,
        status.phase,
        memory.short_term,
        memory.long_term,
        status.drift_learnt,
        a.loss_1 + a.loss_2 + a.loss_3 + b.loss_1 + b.loss_2 + b.loss_3,
        ledger.gas_work,
        ledger.load_work,
        ledger.hose_work,
        stored_energy(loss_a, a.loss_1, a.loss_2, a.loss_3) + stored_energy(loss_b, b.loss_1, b.loss_2, b.loss_3),
        ledger.brake_heat,
        ledger.damping_heat,
        ledger.air_taken,
    )


@law
def sense(joint, state, noise_angle, noise_pressure, elapsed):
    """What the controller is given of a joint."""
    return Measurement(
        read_sensor(joint.angle_sensor, state.motion.angle, noise_angle),
        read_sensor(joint.pressure_sensor, state.hose_a.pressure - state.hose_b.pressure, noise_pressure),
        elapsed,
    )


@kernel
def run_cycles(arm, joints, gains, around, angles, pressures, signals, timing):
    """Run all cycles of a scenario from rest.

    Args: parameter tuples of `physics` and `control`, start angles (joints,) in rad, start pressures (joints, 2) in Pa,
    `Signals`, `Timing`. Returns the records (instants, joints, columns of `Sample`), how many instants are
    valid, and the joint that diverged (-1: none).
    """
    cycles, n = signals.demand.shape
    rows = cycles * timing.records + 1
    out = np.empty((rows, n, COLUMNS))
    sub = timing.steps // timing.records
    h = timing.cycle / timing.steps
    around = Surroundings(
        signals.supply[0], around.supply_temperature, around.ambient_pressure, around.ambient_temperature, 0.0
    )
    joints, gains = list(joints), list(gains)
    states = [joint_at_rest(joints[j], angles[j], pressures[j, 0], pressures[j, 1], around) for j in range(n)]
    measured = [sense(joints[j], states[j], 0.0, 0.0, timing.cycle) for j in range(n)]
    memories = [start(measured[j]) for j in range(n)]
    statuses = [Status(angles[j], 0.0, 0.0, 0.0, 0.0, 0.0) for j in range(n)]
    voltages = [gains[j].null for j in range(n)]
    drives = [Drive(0.0, 0.0, 0.0) for j in range(n)]
    lines = [NOTHING_ASKED for j in range(n)]
    waves = [start_wave(joints[j].valve, 0.0, h) for j in range(n)]
    row = 0
    for k in range(cycles):
        around = Surroundings(
            signals.supply[k],
            around.supply_temperature,
            around.ambient_pressure,
            around.ambient_temperature,
            signals.payload[k],
        )
        for j in range(n):
            measured[j] = sense(joints[j], states[j], signals.noise[k, j, 0], signals.noise[k, j, 1], timing.cycle)
            memories[j], voltages[j], statuses[j] = step(gains[j], memories[j], measured[j], signals.demand[k, j])
            valve = joints[j].valve
            if not timing.closed_loop:
                voltages[j] = valve.centre_voltage + valve.volts_to_full * signals.opening[k, j]
            opening, lines[j] = driven(valve, lines[j], voltages[j] - signals.drift[k, j], timing.cycle)
            drives[j] = Drive(opening, signals.brake[k, j], signals.load[k, j])
            waves[j] = start_wave(valve, timing.cycle * k, h)
        for _ in range(timing.records):
            for j in range(n):
                sample = _sample(joints[j], states[j], around, measured[j], voltages[j], memories[j], statuses[j])
                write_row(out, row, j, sample)
            row += 1
            advance(arm, joints, states, drives, waves, around, h, sub)
            for j in range(n):
                if not is_sound(states[j]):
                    return out, row, j
    for j in range(n):
        noise = signals.noise[cycles, j]
        measured[j] = sense(joints[j], states[j], noise[0], noise[1], timing.cycle)
        sample = _sample(joints[j], states[j], around, measured[j], voltages[j], memories[j], statuses[j])
        write_row(out, row, j, sample)
    return out, row + 1, -1
