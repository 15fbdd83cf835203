"""Plant of a machine as the functions of an FMU: the time loop's own laws, between two control cycles.

So an FMU passes through the states of a simulation run, bit for bit. A control cycle is `drive` with the commands and
signals of the cycle, and `advance` over its steps, at once or in parts.
"""

from collections.abc import Iterator
from math import nan
from typing import Any, NamedTuple

import numpy as np

from layflat.export.entries import Argument, Entry, number_of
from layflat.jit import composition
from layflat.lanes import Like, read_numbers, slots, write_numbers
from layflat.machine import Machine, parameters
from layflat.physics.adjustable import FULL_FRACTIONS, DriveFractions, adjust_fractions
from layflat.physics.driver import ZERO_COMMANDS, CommandDelayLine
from layflat.physics.joint import Drive, JointParameters, JointState, Surroundings, is_sound
from layflat.physics.plant import advance_arm, pack_joints, states_at_rest
from layflat.physics.step import STEP
from layflat.physics.valves import start_wave, weaken_wave
from layflat.sim.kernel import JointRecord, joint_record
from layflat.sim.loop import NO_INJECTION, JointSignals, Noise, drive_joint, sense
from layflat.sim.run import make_timing
from layflat.sim.stepping import PlantSetting, carry_at_rest


class AirTemperatures(NamedTuple):
    """Temperatures of the air."""

    supply_temperature: float  # K
    ambient_temperature: float  # K


class PlantParameters(NamedTuple):
    """Parameters of a plant that stay constant while it is advanced."""

    arm: Any
    joints: tuple[JointParameters, ...]
    air: AirTemperatures


class SharedInputs(NamedTuple):
    """Input signals that all joints share."""

    supply: float  # absolute supply pressure, Pa
    payload: float  # payload, kg
    ambient: float  # absolute ambient pressure, Pa


class DriveInputs(NamedTuple):
    """Input signals of a joint in a control cycle."""

    voltage: float  # control voltage, V
    commanded_shares: DriveFractions  # commanded fractions of brake, dither and supply
    brake: float  # fraction of the brake's torque, 1
    dither: float  # fraction of the valve's dither, 1
    load: float  # external torque on a joint, N m
    drift: float  # shift of the valve's centre, V


class DrivenJoint(NamedTuple):
    """State of a joint within a control cycle."""

    state: JointState
    line: CommandDelayLine
    shares: DriveFractions  # at the start of the coming cycle
    drive: Drive
    wave: Any  # dither or carrier of the coming step
    voltage: float  # V


class PlantFunctions:
    """Plant of a machine as entries, in double precision.

    Args:
        machine: the machine.
    """

    def __init__(self, machine: Machine) -> None:
        around, n = parameters.surroundings(machine), len(machine.joints)
        air = AirTemperatures(around.supply_temperature, around.ambient_temperature)
        self.cycle = machine.cycle
        self.steps = make_timing(machine.cycle, STEP, 1, machine).steps
        self.parameters = PlantParameters(parameters.arm(machine), parameters.joints(machine), air)
        self.shared = SharedInputs(around.supply_pressure, around.payload, around.ambient_pressure)
        voltages = [float(joint.valve.centre_voltage) for joint in self.parameters.joints]
        self.inputs = tuple(DriveInputs(v, FULL_FRACTIONS, 1.0, 1.0, 0.0, 0.0) for v in voltages)
        setting = PlantSetting(self.parameters.arm, self.parameters.joints, machine.cycle, around)
        carries = carry_at_rest(setting, np.zeros(n), np.full((n, 2), np.nan), machine.cycle / self.steps)
        drive = Drive(0.0, 0.0, 0.0, around.supply_pressure)
        self.states = tuple(
            DrivenJoint(carry.state, ZERO_COMMANDS, FULL_FRACTIONS, drive, carry.wave, voltage)
            for carry, voltage in zip(carries, voltages, strict=True)
        )
        self.outputs = (JointRecord(*[0.0] * len(JointRecord._fields)),) * n

    def __iter__(self) -> Iterator[Entry]:
        """Yield the entries: rest, sample, record, drive, advance."""
        n = len(self.states)
        rest, sample, record = _state_functions(self)
        drive, advance = _motion_functions(self)
        constants = Argument("parameters", "parameters of the plant", self.parameters)
        shared = Argument("shared", "input signals that all joints share", self.shared)
        state = Argument("state", "state of the joints", self.states, output=True)
        inputs = Argument("inputs", "input signals of the joints", self.inputs)
        start = Argument("start", "angles, and pressures of hoses A and B", ((0.0,) * n,) * 3)
        noise = Argument("noise", "standard normal samples of the sensors", ((0.0, 0.0),) * n)
        measured = Argument("measured", "readings of the sensors", ((0.0,) * n,) * 2, output=True)
        outputs = Argument("outputs", "output signals of the joints", self.outputs, output=True)
        time = Argument("time", "time at the start of the cycle, s")
        steps = Argument("steps", "number of steps", number="int32_t")
        yield Entry("rest", "Set the state to rest.", (constants, start, shared, state), rest)
        yield Entry("sample", "Read the sensors.", (constants, state, noise, measured), sample)
        yield Entry("record", "Write the outputs.", (constants, shared, state, measured, outputs), record)
        yield Entry("drive", "Start a control cycle.", (constants, inputs, shared, time, state), drive)
        diverged = "-1, or the number of the joint whose state became invalid"
        yield Entry("advance", "Advance by steps.", (constants, inputs, shared, steps, state), advance, diverged)


@composition
def surrounded(air: Any, shared: Any) -> Any:
    """Return the surroundings of the joints."""
    return Surroundings(shared.supply, air.supply_temperature, shared.ambient, air.ambient_temperature, shared.payload)


def _state_functions(plant: PlantFunctions) -> tuple[Any, ...]:
    """Return the functions of pointers of the entries rest, sample and record."""
    from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

    n, h = len(plant.states), plant.cycle / plant.steps
    like, state_like, shared_like = map(Like.from_tuple, (plant.parameters, plant.states[0], plant.shared))
    numbers, columns, records = number_of(plant.parameters), number_of(plant.states[0]), len(JointRecord._fields)
    row_like = (0.0,) * n

    def rest(constants, start, shared, state):  # type: ignore[no-untyped-def]
        own, rows = read_numbers(like, carray(constants, (numbers,))), carray(state, (n, columns))
        around = surrounded(own.air, read_numbers(shared_like, carray(shared, (3,))))
        places, firsts = slots(own.joints), carray(start, (3, n))
        angles, a, b = (
            read_numbers(row_like, firsts[0]), read_numbers(row_like, firsts[1]), read_numbers(row_like, firsts[2])
        )  # fmt: skip
        states = slots(states_at_rest(own.arm, own.joints, angles, a, b, around))
        for j in range(n):
            valve = places[j].valve
            drive, wave = Drive(0.0, 0.0, 0.0, around.supply_pressure), start_wave(valve, 0.0, h)
            held = valve.centre_voltage
            write_numbers(rows[j], DrivenJoint(states[j], ZERO_COMMANDS, FULL_FRACTIONS, drive, wave, held))

    def sampled(constants, state, noise, measured):  # type: ignore[no-untyped-def]
        places, rows = slots(read_numbers(like, carray(constants, (numbers,))).joints), carray(state, (n, columns))
        samples, out = carray(noise, (n, 2)), carray(measured, (2, n))
        for j in range(n):
            motion = read_numbers(state_like, rows[j]).state
            out[0, j], out[1, j] = sense(places[j], motion, Noise(samples[j, 0], samples[j, 1]))

    def recorded(constants, shared, state, measured, outputs):  # type: ignore[no-untyped-def]
        own, rows = read_numbers(like, carray(constants, (numbers,))), carray(state, (n, columns))
        around = surrounded(own.air, read_numbers(shared_like, carray(shared, (3,))))
        places, readings, out = slots(own.joints), carray(measured, (2, n)), carray(outputs, (n, records))
        for j in range(n):
            joint = read_numbers(state_like, rows[j])
            record = joint_record(places[j], joint.state, around, readings[0, j], readings[1, j], joint.voltage)
            write_numbers(out[j], record)

    return rest, sampled, recorded


def _motion_functions(plant: PlantFunctions) -> tuple[Any, ...]:
    """Return the functions of pointers of the entries drive and advance."""
    from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

    n, cycle, h = len(plant.states), plant.cycle, plant.cycle / plant.steps
    like, state_like, shared_like = map(Like.from_tuple, (plant.parameters, plant.states[0], plant.shared))
    input_like = Like.from_tuple(plant.inputs[0])
    numbers, columns, items = (number_of(one) for one in (plant.parameters, plant.states[0], plant.inputs[0]))

    def driven(constants, inputs, shared, time, state):  # type: ignore[no-untyped-def]
        own, rows = read_numbers(like, carray(constants, (numbers,))), carray(state, (n, columns))
        around = surrounded(own.air, read_numbers(shared_like, carray(shared, (3,))))
        places, inputs_of = slots(own.joints), carray(inputs, (n, items))
        for j in range(n):
            valve, joint, came = (
                places[j].valve,
                read_numbers(state_like, rows[j]),
                read_numbers(input_like, inputs_of[j]),
            )
            acting = JointSignals(0.0, 0.0, 0.0, 0.0, nan, nan, came.brake, came.dither, came.load, came.drift)
            means, after = adjust_fractions(places[j].adjustables, joint.shares, came.commanded_shares, cycle)
            drive, voltage, line = drive_joint(
                places[j], joint.state, joint.line, acting, NO_INJECTION, came.voltage, means, around, cycle
            )
            wave = weaken_wave(valve, start_wave(valve, time, h), means.dither * came.dither)
            write_numbers(rows[j], DrivenJoint(joint.state, line, after, drive, wave, voltage))

    def advanced(constants, inputs, shared, steps, state):  # type: ignore[no-untyped-def]
        own, rows = read_numbers(like, carray(constants, (numbers,))), carray(state, (n, columns))
        around = surrounded(own.air, read_numbers(shared_like, carray(shared, (3,))))
        first, inputs_of = read_numbers(state_like, rows[0]), carray(inputs, (n, items))
        places = slots(own.joints)
        joined = pack_joints(own.arm, places)
        states, drives, waves = (
            slots(own.joints, first.state),
            slots(own.joints, first.drive),
            slots(own.joints, first.wave),
        )
        for j in range(n):
            joint, came = read_numbers(state_like, rows[j]), read_numbers(input_like, inputs_of[j])
            before = joint.drive
            states[j], waves[j] = joint.state, joint.wave
            drives[j] = Drive(before.opening, before.brake_torque, came.load, before.supply_pressure)
        advance_arm(own.arm, joined, states, drives, waves, around, h, steps)
        diverged = -1
        for j in range(n):
            joint = read_numbers(state_like, rows[j])
            write_numbers(
                rows[j], DrivenJoint(states[j], joint.line, joint.shares, joint.drive, waves[j], joint.voltage)
            )
            if diverged < 0 and not is_sound(states[j]):
                diverged = j
        return diverged

    return driven, advanced
