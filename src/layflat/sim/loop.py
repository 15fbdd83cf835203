"""The compiled time loop: acting signals, sensors, controller, plant, records, one control cycle after the other.

One loop serves a single run and runs in SIMD lanes. `LoopPorts` hold the differences: the source of the signals and the
records. The loop can stop after any control cycle and resume: its whole state is in `MachineState`.
"""

from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.control import Demand, Sensed, step, wake
from layflat.jit import composition, law
from layflat.lanes import each, gather, in_lanes, select, slots
from layflat.physics.adjustable import adjust_fractions, regulated_pressure
from layflat.physics.joint import Drive, JointParameters, Surroundings
from layflat.physics.plant import advance_arm, pack_joints
from layflat.physics.sensor import read_sensor
from layflat.physics.valves import driven_opening, start_wave, weaken_wave


class InjectionGains(NamedTuple):
    """Gains of the output injection that keeps a simulated joint near its log."""

    voltage: float  # per error of the angle, added to voltages that the scenario sets, V/rad
    pressure: float  # per differential pressure, subtracted from these voltages, V/Pa
    spring: float  # torque per error of the angle, N m/rad
    damper: float  # torque per error of the velocity, N m s/rad


NO_INJECTION = InjectionGains(0.0, 0.0, 0.0, 0.0)


class JointSignals(NamedTuple):
    """Signals of a joint in a control cycle: rows of the table in motion/scenario.py."""

    demand: float  # rad
    demand_velocity: float  # rad/s
    demand_acceleration: float  # rad/s2
    demand_stiffness: float  # N m/rad; 0 for none
    opening: float  # of the valve, -1..1; NaN where the controller or a voltage drives
    voltage: float  # V; NaN where the controller or an opening drives
    brake: float  # fraction of the brake's torque, 0..1
    dither: float  # fraction of the valve's dither, 0..1
    load: float  # external torque, N m
    drift: float  # shift of the valve's centre, V


class SharedSignals(NamedTuple):
    """Signals of a control cycle that all joints share: rows of the same table."""

    supply: float  # gauge, Pa
    payload: float  # kg
    ambient: float  # absolute, Pa


ZERO_JOINT_SIGNALS, ZERO_SHARED_SIGNALS = (
    JointSignals(*[0.0] * len(JointSignals._fields)),
    SharedSignals(*[0.0] * len(SharedSignals._fields)),
)
DEMAND_SIGNALS = ("demand", "demand_velocity", "demand_acceleration", "demand_stiffness")  # in the order of `Demand`


class Signals(NamedTuple):
    """Signals of a scenario over control cycles; NaN where the machine's own value holds."""

    by_joint: np.ndarray  # items of `JointSignals`, (cycles, joints, signals)
    shared: np.ndarray  # items of `SharedSignals`, (cycles, signals)

    def named(self, name: str) -> Array:
        """Return one signal: (cycles, joints), or (cycles,) if all joints share it."""
        if name in SharedSignals._fields:
            return self.shared[:, SharedSignals._fields.index(name)]
        return self.by_joint[:, :, JointSignals._fields.index(name)]


class Noise(NamedTuple):
    """Standard normal samples of a joint's sensors."""

    angle: float
    pressure: float


ZERO_NOISE = Noise(0.0, 0.0)


class LoopState(NamedTuple):
    """Working state of the loop within a control cycle: slots with an item per joint."""

    acting: Any  # `JointSignals`
    injections: Any  # `InjectionGains`
    noise: Any
    drives: Any
    lines: Any  # commands on their way to the valves
    waves: Any  # dither or carrier of the valves' drivers
    voltages: Any
    shares: Any  # fractions of the adjustable inputs at the start of the coming cycle


@law
def is_number(value):
    """Return whether a value is set, that is, not NaN."""
    return value == value  # noqa: PLR0124


@law
def surroundings(air, shared):
    """Return the surroundings of all joints in a control cycle: the machine's air with the shared signals."""
    p_a = shared.ambient
    return Surroundings(shared.supply + p_a, air.supply_temperature, p_a, air.ambient_temperature, shared.payload)


@law
def sense(joint, state, noise):
    """Return the readings of a joint's sensors: angle (rad) and differential pressure (Pa)."""
    return (
        read_sensor(joint.angle_sensor, state.motion.angle, noise.angle),
        read_sensor(joint.pressure_sensor, state.hose_a.pressure - state.hose_b.pressure, noise.pressure),
    )


@composition
def sense_all(joints, states, noise):
    """Return the readings of all joints' sensors; joints, states and noise are slots."""
    zero = 0.0 * states[0].motion.angle
    angles, pressures = slots(states, zero), slots(states, zero)
    for j in range(len(states)):
        angles[j], pressures[j] = sense(joints[j], states[j], noise[j])
    return Sensed(gather(states, angles), gather(states, pressures))


@law
def _joint_demand(acting):
    return acting.demand, acting.demand_velocity, acting.demand_acceleration, acting.demand_stiffness


@composition
def _arm_demand(acting):
    """Return the `Demand` of the arm from the signals of its joints, a slot each."""
    angles, velocities, accelerations, stiffnesses = each(_joint_demand, gather(acting, acting))
    return Demand(angles, velocities, accelerations, stiffnesses)


@composition
def drive_joint(joint, state, line, acting, gains, command, shares, around, cycle):
    """Return a joint's drive for a control cycle, the voltage of its valve, and the line of commands after it.

    A set opening replaces the controller's `command` (V), and a set voltage with its output injection replaces both.
    The valve gets the voltage less the drift; the returned voltage is without drift.
    """
    valve = joint.valve
    voltage = select(is_number(acting.opening), valve.centre_voltage + valve.volts_to_full * acting.opening, command)
    motion = state.motion
    error, difference = acting.demand - motion.angle, state.hose_a.pressure - state.hose_b.pressure
    injected = acting.voltage + gains.voltage * error - gains.pressure * difference
    voltage = select(is_number(acting.voltage), injected, voltage)
    opening, line = driven_opening(valve, line, voltage - acting.drift, cycle)
    supply = regulated_pressure(shares.supply, around.supply_pressure, around.ambient_pressure)
    load = acting.load + gains.spring * error + gains.damper * (acting.demand_velocity - motion.velocity)
    return Drive(opening, shares.brake * (acting.brake * joint.brake_torque), load, supply), voltage, line


@composition
def control_cycle(joints, settings, memory, states, loop, around, cycle):
    """Step the control law; return the readings, the law's memory and its report, and set the drives.

    Args: joints (slots); settings and memory of the control law; states (slots); `LoopState` with this cycle's
    `acting`, `noise` and whole `waves`, whose drives, voltages, lines, waves and shares are updated; `Surroundings`;
    control cycle, s.
    """
    zero = 0.0 * states[0].motion.angle
    sensed = sense_all(joints, states, loop.noise)
    after, command, report = step(settings, memory, sensed, _arm_demand(loop.acting), cycle)
    commands, commanded_shares = slots(in_lanes(command.voltage, zero)), slots(in_lanes(command.shares, zero))
    for j in range(len(states)):
        joint, state = joints[j], states[j]
        shares, loop.shares[j] = adjust_fractions(joint.adjustables, loop.shares[j], commanded_shares[j], cycle)
        loop.drives[j], loop.voltages[j], loop.lines[j] = drive_joint(
            joint, state, loop.lines[j], loop.acting[j], loop.injections[j], commands[j], shares, around, cycle
        )
        loop.waves[j] = weaken_wave(joint.valve, loop.waves[j], shares.dither * loop.acting[j].dither)
    return sensed, in_lanes(after, zero), in_lanes(report, zero)


class Case(NamedTuple):
    """Parameters of a run: tuples of `physics` and `control`."""

    arm: Any
    joints: tuple[JointParameters, ...]
    settings: Any  # of the control law
    air: Surroundings


class Timing(NamedTuple):
    """Time grid of a run: control cycle (s), steps of the plant per cycle, records per cycle."""

    cycle: float
    steps: int
    records: int


class CycleSpan(NamedTuple):
    """Range of control cycles to simulate: from `first` up to, but without, `last`."""

    first: int
    last: int


class MachineState(NamedTuple):
    """State of a machine between control cycles; what changes is in slots with an item per joint, updated in place."""

    arm: Any
    settings: Any  # of the control law
    air: Surroundings  # without signals
    around: Any  # `Surroundings` of the last cycle, or at the start: one item for all joints
    acting: Any  # `JointSignals` of the last cycle
    joints: Any
    states: Any
    lines: Any  # commands on their way to the valves
    shares: Any  # fractions of the adjustable inputs at the start of the coming cycle
    injections: Any  # `InjectionGains`
    memory: Any  # of the control law: one item for all joints


class LoopPorts(NamedTuple):
    """Laws that connect the loop with its inputs and records; each works on its own `run`."""

    observe: Any  # observe(run, arm, states, k, cycle) reads the states at the start of cycle k; True ends the run
    load: Any  # load(run, air, around, acting, noise, k) writes the signals of cycle k into these slots
    record: Any  # record(run, joints, states, around, sensed, voltages, report, k, i) at the start of part i of cycle k
    check: Any  # check(run, states, k, i) reads the states at the end of that part; True stops the run


@composition
def initial_memory(settings, joints, states):
    """Return the control law's memory for a machine at rest, by readings without noise; joints and states are slots."""
    zero = 0.0 * states[0].motion.angle
    return in_lanes(wake(settings, sense_all(joints, states, slots(joints, in_lanes(ZERO_NOISE, zero)))), zero)


@composition
def run_span(machine, span, timing, ports, run):
    """Simulate a machine over a span of control cycles, in place, or until a port stops the run.

    Args: `MachineState`, which is updated; `CycleSpan`; `Timing`; `LoopPorts`; the `run` that the ports work on.
    """
    arm, joints, states, air = machine.arm, machine.joints, machine.states, machine.air
    joined = pack_joints(arm, joints)
    zero, h, part = 0.0 * air.ambient_pressure, timing.cycle / timing.steps, timing.steps // timing.records
    loop = LoopState(
        machine.acting,
        machine.injections,
        slots(joints, in_lanes(ZERO_NOISE, zero)),
        slots(joints, Drive(zero, zero, zero, zero)),
        machine.lines,
        slots(joints, start_wave(joints[0].valve, 0.0, h)),
        slots(joints, zero),
        machine.shares,
    )
    for k in range(span.first, span.last):
        if ports.observe(run, arm, states, k, timing.cycle):
            break
        ports.load(run, air, machine.around, loop.acting, loop.noise, k)
        around = machine.around[0]
        for j in range(len(joints)):
            loop.waves[j] = start_wave(joints[j].valve, timing.cycle * k, h)
        sensed, machine.memory[0], report = control_cycle(
            joints, machine.settings, machine.memory[0], states, loop, around, timing.cycle
        )
        stops = False
        for i in range(timing.records):
            ports.record(run, joints, states, around, sensed, loop.voltages, report, k, i)
            advance_arm(arm, joined, states, loop.drives, loop.waves, around, h, part)
            stops = ports.check(run, states, k, i)
            if stops:
                break
        if stops:
            break
