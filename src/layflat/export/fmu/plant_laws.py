"""Laws of a plant between two control cycles, on tuples of all joints: the functions of an FMU.

So an FMU passes through the states of a simulation run, bit for bit. A control cycle is `drive_joints` with the
commands and signals of the cycle, and `advance_joints` over its steps, at once or in parts.
"""

# mypy: disable-error-code="no-untyped-def"
# Laws are untyped.

from math import nan
from typing import Any, NamedTuple

from layflat.control import Sensed
from layflat.jit import composition, law
from layflat.lanes import each, gather, slots
from layflat.physics.adjustable import FULL_FRACTIONS, DriveFractions, adjust_fractions
from layflat.physics.driver import ZERO_COMMANDS, CommandDelayLine
from layflat.physics.joint import Drive, JointParameters, JointState, Surroundings, is_sound
from layflat.physics.plant import advance_arm, pack_joints, states_at_rest
from layflat.physics.valves import start_wave, weaken_wave
from layflat.sim.kernel import joint_record
from layflat.sim.loop import NO_INJECTION, JointSignals, drive_joint, sense


class AirTemperatures(NamedTuple):
    """Temperatures of the air."""

    supply_temperature: float  # K
    ambient_temperature: float  # K


class PlantParameters(NamedTuple):
    """Parameters of a plant that stay constant while it is advanced."""

    arm: Any
    joints: tuple[JointParameters, ...]
    air: AirTemperatures


class StartValues(NamedTuple):
    """Angles at which the joints rest, and absolute pressures in hoses A and B; nan: those that hold the arm."""

    angle: tuple[float, ...]  # rad
    pressure_a: tuple[float, ...]  # Pa
    pressure_b: tuple[float, ...]  # Pa


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


@composition
def _surroundings(air, shared):
    """Return the surroundings of the joints."""
    return Surroundings(shared.supply, air.supply_temperature, shared.ambient, air.ambient_temperature, shared.payload)


@law
def _driven_at_rest(joint, state, around, h):
    """Return a joint at rest before its first control cycle."""
    valve, drive = joint.valve, Drive(0.0, 0.0, 0.0, around.supply_pressure)
    wave = start_wave(valve, 0.0, h)
    return DrivenJoint(state, ZERO_COMMANDS, FULL_FRACTIONS, drive, wave, valve.centre_voltage)


@composition
def rest_joints(constants, start, shared, h):
    """Return the joints at rest.

    Args:
        constants: `PlantParameters`.
        start: `StartValues`.
        shared: `SharedInputs`.
        h: step, s.
    """
    around = _surroundings(constants.air, shared)
    states = states_at_rest(constants.arm, constants.joints, start.angle, start.pressure_a, start.pressure_b, around)
    return each(_driven_at_rest, constants.joints, states, around, h)


@law
def _sample_joint(joint, driven, noise):
    """Return angle (rad) and differential pressure (Pa) as a joint's sensors read them."""
    return sense(joint, driven.state, noise)


@composition
def sample_joints(constants, joints, noise):
    """Return the readings of all sensors; `noise` has a `Noise` of each joint."""
    angles, pressures = each(_sample_joint, constants.joints, joints, noise)
    return Sensed(angles, pressures)


@law
def _record_joint(joint, driven, around, angle, pressure):
    """Return the signals of a joint with these readings of its sensors."""
    return joint_record(joint, driven.state, around, angle, pressure, driven.voltage)


@composition
def record_joints(constants, shared, joints, measured):
    """Return a `JointRecord` of each joint with the readings of its sensors."""
    around = _surroundings(constants.air, shared)
    return each(_record_joint, constants.joints, joints, around, measured.angle, measured.differential_pressure)


@law
def _drive_joint(joint, driven, came, around, time, cycle, h):
    """Return a joint at the start of a control cycle, with the drive that its inputs `came` command."""
    acting = JointSignals(0.0, 0.0, 0.0, 0.0, nan, nan, came.brake, came.dither, came.load, came.drift)
    means, after = adjust_fractions(joint.adjustables, driven.shares, came.commanded_shares, cycle)
    drive, voltage, line = drive_joint(
        joint, driven.state, driven.line, acting, NO_INJECTION, came.voltage, means, around, cycle
    )
    wave = weaken_wave(joint.valve, start_wave(joint.valve, time, h), means.dither * came.dither)
    return DrivenJoint(driven.state, line, after, drive, wave, voltage)


@composition
def drive_joints(constants, inputs, shared, time, joints, cycle, h):
    """Return the joints at the start of a control cycle.

    Args:
        constants: `PlantParameters`.
        inputs: `DriveInputs` of each joint.
        shared: `SharedInputs`.
        time: time, s.
        joints: `DrivenJoint` of each joint.
        cycle: control cycle, s.
        h: step, s.
    """
    return each(_drive_joint, constants.joints, joints, inputs, _surroundings(constants.air, shared), time, cycle, h)


@law
def _state_of(driven):
    return driven.state


@law
def _wave_of(driven):
    return driven.wave


@law
def _loaded_drive(driven, came):
    """Return the drive of a joint with the load of its inputs, which may change within a cycle."""
    before = driven.drive
    return Drive(before.opening, before.brake_torque, came.load, before.supply_pressure)


@law
def _advanced_joint(driven, state, wave):
    return DrivenJoint(state, driven.line, driven.shares, driven.drive, wave, driven.voltage)


@law
def _is_sound(driven):
    return is_sound(driven.state)


@composition
def advance_joints(constants, inputs, shared, steps, joints, h):
    """Return the joints after steps of h seconds, and the number of the first that diverged, or -1.

    Args:
        constants: `PlantParameters`.
        inputs: `DriveInputs` of each joint.
        shared: `SharedInputs`.
        steps: number of steps.
        joints: `DrivenJoint` of each joint.
        h: step, s.
    """
    around, packed = _surroundings(constants.air, shared), pack_joints(constants.arm, slots(constants.joints))
    states, waves = slots(each(_state_of, joints)), slots(each(_wave_of, joints))
    advance_arm(constants.arm, packed, states, slots(each(_loaded_drive, joints, inputs)), waves, around, h, steps)
    after = each(_advanced_joint, joints, gather(joints, states), gather(joints, waves))
    sound, diverged = each(_is_sound, after), -1
    for j in range(len(sound)):
        if diverged < 0 and not sound[j]:
            diverged = j
    return after, diverged
