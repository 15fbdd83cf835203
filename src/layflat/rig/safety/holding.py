"""Joints that are held, and valves without air, as compiled code; functions take `CycleRows`."""

# mypy: disable-error-code="no-untyped-def"

from math import isfinite

from layflat.jit import composition, law
from layflat.lanes import read_numbers, write_numbers
from layflat.rig.safety.cycle_numbers import (
    FIRST_JOINT_MEMORY,
    JOINT,
    MIN_EVEN_TIME,
    RIG,
    RIG_TEMPLATE,
    SETTINGS_TEMPLATE,
)
from layflat.rig.safety.detectors import INITIAL_MEMORY, bounds
from layflat.rig.safety.detectors.sample import AIR_LEVEL, MOTION_LEVEL, SENSORS_LEVEL
from layflat.rig.safety.faults import FAULT, MODE, STATE
from layflat.rig.safety.ledger import VENT_FROM, VENT_JOINT_FROM

FIRST_LINES = bounds.SupplyMemory()


@law
def has_air(mode):
    """Return whether the dump valve connects the supply in a mode of the valves."""
    return mode == MODE.HOLD or mode == MODE.FOLLOW  # noqa: PLR1714  # compiled, a tuple of two is slower


@law
def detection_level(state, mode):
    """Return the level of detection: of sensors without air, of motion in a soft start, else all (AIR_LEVEL)."""
    return (MOTION_LEVEL if state == STATE.STARTING else AIR_LEVEL) if has_air(mode) else SENSORS_LEVEL


@composition
def reset_detectors(rows):
    """Reset the memory of the detectors; the estimate of the air, and demands, are kept."""
    for j in range(len(rows.joints)):
        write_numbers(rows.joints[j, JOINT.detectors :], INITIAL_MEMORY)
    write_numbers(rows.memory[RIG.lines :], FIRST_LINES)
    rows.memory[RIG.even] = MIN_EVEN_TIME


@law
def stopping_angle(settings, estimate, plans):
    """Return the angle, rad, at which a joint that stops now is held; NaN where it is unknown.

    With a law that plans its motion it is the angle that braking leads to: a joint that stops at once accelerates the
    others. It is clipped to the working stroke.
    """
    angle, working = estimate.averaged_angle, settings.moving.working
    if plans > 0.0:
        velocity = estimate.averaged_velocity
        angle = angle + 0.5 * velocity * abs(velocity) / settings.moving.braking
    return min(max(angle, -working), working)


@composition
def hold_joints(rows, at_demands):
    """Set the demands to constant angles: those at which joints are or can stop, or the present ones."""
    plans = read_numbers(RIG_TEMPLATE, rows.rig).plans
    for j in range(len(rows.joints)):
        memory = read_numbers(FIRST_JOINT_MEMORY, rows.joints[j])
        held = stopping_angle(read_numbers(SETTINGS_TEMPLATE, rows.settings[j]), memory.estimate, plans)
        hold_joint(rows, j, memory.demand.demand if at_demands else held)


@composition
def hold_joint(rows, j, angle):
    """Set the demand of a joint to a constant angle, rad; where that is not finite, the angle of the demand stays."""
    joint = rows.joints[j]
    held = angle if isfinite(angle) else joint[JOINT.demand]
    joint[JOINT.demand] = joint[JOINT.demand + 1] = held
    joint[JOINT.velocity] = joint[JOINT.acceleration] = 0.0


@composition
def write_voltages_without_air(rows):
    """Write the voltages of the valves by their mode, without air.

    VENT_JOINT vents only faulty joints; CENTRE vents the fuller hose of joints whose valve is unresponsive.
    """
    rig, mode = read_numbers(RIG_TEMPLATE, rows.rig), rows.memory[RIG.mode]
    for j in range(len(rows.joints)):
        joint = read_numbers(FIRST_JOINT_MEMORY, rows.joints[j])
        fault = joint.latched
        volts = rig.vented if mode == MODE.VENT else rig.centre
        if mode == MODE.VENT_JOINT and VENT_JOINT_FROM <= fault < VENT_FROM:
            volts = rig.vented
        if mode == MODE.CENTRE and fault == FAULT.VALVE_UNRESPONSIVE:
            # One hose may be burst: the other throws the joint into its stop unless it is vented at once.
            volts = rig.voltage_low if joint.estimator.pressure_0 > 0.0 else rig.voltage_high
        rows.joints[j, JOINT.voltage] = volts
