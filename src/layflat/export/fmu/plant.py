"""Plant of a machine as the functions of an FMU: the laws of `plant_laws` on rows of numbers."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from layflat.control import Sensed
from layflat.export.entries import Argument, Entry, number_of
from layflat.export.fmu.plant_laws import (
    AirTemperatures,
    DriveInputs,
    DrivenJoint,
    PlantParameters,
    SharedInputs,
    StartValues,
    advance_joints,
    drive_joints,
    record_joints,
    rest_joints,
    sample_joints,
)
from layflat.lanes import Like, read_numbers, write_numbers
from layflat.machine import Machine, parameters
from layflat.physics.adjustable import FULL_FRACTIONS
from layflat.physics.driver import ZERO_COMMANDS
from layflat.physics.joint import Drive
from layflat.physics.step import STEP
from layflat.sim.kernel import JointRecord
from layflat.sim.loop import ZERO_NOISE
from layflat.sim.run import make_timing
from layflat.sim.stepping import PlantSetting, carry_at_rest


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
        self.start, self.measured = StartValues(*[(0.0,) * n] * 3), Sensed(*[(0.0,) * n] * 2)
        self.noise = (ZERO_NOISE,) * n

    def __iter__(self) -> Iterator[Entry]:
        """Yield the entries: rest, sample, record, drive, advance."""
        rest, sample, record = _state_functions(self)
        drive, advance = _motion_functions(self)
        cycle, h = self.cycle, self.cycle / self.steps
        constants = Argument("parameters", "parameters of the plant", self.parameters)
        shared = Argument("shared", "input signals that all joints share", self.shared)
        state = Argument("state", "state of the joints", self.states)
        written, updated = (replace(state, output=True, updated=one) for one in (False, True))
        inputs = Argument("inputs", "input signals of the joints", self.inputs)
        start = Argument("start", "angles, and pressures of hoses A and B", self.start)
        noise = Argument("noise", "standard normal samples of the sensors", self.noise)
        measured = Argument("measured", "readings of the sensors", self.measured)
        readings = replace(measured, output=True)
        outputs = Argument("outputs", "output signals of the joints", self.outputs, output=True)
        time = Argument("time", "time at the start of the cycle, s")
        steps = Argument("steps", "number of steps", number="int32_t")
        diverged = "-1, or the number of the joint whose state became invalid"
        yield Entry("rest", "Set the state to rest.", (constants, start, shared, written), rest,
                    law=rest_joints, constants=(h,))  # fmt: skip
        yield Entry("sample", "Read the sensors.", (constants, state, noise, readings), sample, law=sample_joints)
        yield Entry("record", "Write the outputs.", (constants, shared, state, measured, outputs), record,
                    law=record_joints)  # fmt: skip
        yield Entry("drive", "Start a control cycle.", (constants, inputs, shared, time, updated), drive,
                    law=drive_joints, constants=(cycle, h))  # fmt: skip
        yield Entry("advance", "Advance by steps.", (constants, inputs, shared, steps, updated), advance, diverged,
                    law=advance_joints, constants=(h,))  # fmt: skip


def _state_functions(plant: PlantFunctions) -> tuple[Any, ...]:
    """Return the functions of pointers of the entries rest, sample and record."""
    from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

    h, tuples = plant.cycle / plant.steps, (plant.parameters, plant.start, plant.shared, plant.states, plant.noise)
    own_like, start_like, shared_like, state_like, noise_like = map(Like.from_tuple, tuples)
    numbers, starts, _, states, samples = map(number_of, tuples)
    measured_like, readings, records = (
        Like.from_tuple(plant.measured), number_of(plant.measured), number_of(plant.outputs)
    )  # fmt: skip

    def rest(parameters, start, shared, state):  # type: ignore[no-untyped-def]
        own, around = (
            read_numbers(own_like, carray(parameters, (numbers,))), read_numbers(shared_like, carray(shared, (3,)))
        )  # fmt: skip
        after = rest_joints(own, read_numbers(start_like, carray(start, (starts,))), around, h)
        write_numbers(carray(state, (states,)), after)

    def sampled(parameters, state, noise, measured):  # type: ignore[no-untyped-def]
        own, joints = (
            read_numbers(own_like, carray(parameters, (numbers,))), read_numbers(state_like, carray(state, (states,)))
        )  # fmt: skip
        after = sample_joints(own, joints, read_numbers(noise_like, carray(noise, (samples,))))
        write_numbers(carray(measured, (readings,)), after)

    def recorded(parameters, shared, state, measured, outputs):  # type: ignore[no-untyped-def]
        own, around = (
            read_numbers(own_like, carray(parameters, (numbers,))), read_numbers(shared_like, carray(shared, (3,)))
        )  # fmt: skip
        joints = read_numbers(state_like, carray(state, (states,)))
        sensed = read_numbers(measured_like, carray(measured, (readings,)))
        write_numbers(carray(outputs, (records,)), record_joints(own, around, joints, sensed))

    return rest, sampled, recorded


def _motion_functions(plant: PlantFunctions) -> tuple[Any, ...]:
    """Return the functions of pointers of the entries drive and advance."""
    from numba import carray  # type: ignore[attr-defined]  # noqa: PLC0415  # only where something is exported

    cycle, h = plant.cycle, plant.cycle / plant.steps
    tuples = plant.parameters, plant.inputs, plant.shared, plant.states
    own_like, inputs_like, shared_like, state_like = map(Like.from_tuple, tuples)
    numbers, items, _, states = map(number_of, tuples)

    def driven(parameters, inputs, shared, time, state):  # type: ignore[no-untyped-def]
        own, came = (
            read_numbers(own_like, carray(parameters, (numbers,))), read_numbers(inputs_like, carray(inputs, (items,)))
        )  # fmt: skip
        around, rows = read_numbers(shared_like, carray(shared, (3,))), carray(state, (states,))
        write_numbers(rows, drive_joints(own, came, around, time, read_numbers(state_like, rows), cycle, h))

    def advanced(parameters, inputs, shared, steps, state):  # type: ignore[no-untyped-def]
        own, came = (
            read_numbers(own_like, carray(parameters, (numbers,))), read_numbers(inputs_like, carray(inputs, (items,)))
        )  # fmt: skip
        around, rows = read_numbers(shared_like, carray(shared, (3,))), carray(state, (states,))
        after, diverged = advance_joints(own, came, around, steps, read_numbers(state_like, rows), h)
        write_numbers(rows, after)
        return diverged

    return driven, advanced
