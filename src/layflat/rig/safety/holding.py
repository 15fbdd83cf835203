"""Joints that are held, and valves without air, as compiled code; functions take `CycleRows`."""

# mypy: disable-error-code="no-untyped-def"

from math import isfinite

from layflat.jit import composition, law
from layflat.lanes import read_numbers, write_numbers
from layflat.rig.named import offset_of
from layflat.rig.safety.cycle_numbers import (
    FIRST_JOINT_MEMORY,
    JOINT_AT,
    LIMIT_AT,
    MIN_EVEN_TIME,
    RIG_AT,
    SETTING_AT,
    SETTINGS_TEMPLATE,
)
from layflat.rig.safety.detectors import INITIAL_MEMORY, bounds
from layflat.rig.safety.detectors.sample import AIR_LEVEL, MOTION_LEVEL, SENSORS_LEVEL
from layflat.rig.safety.faults import FAULT_NO, MODE_NO, STATE_NO
from layflat.rig.safety.ledger import VENT_FROM, VENT_JOINT_FROM

FIRST_LINES = bounds.SupplyMemory()
LAST_PRESSURE_AT = offset_of(FIRST_JOINT_MEMORY, "estimator.pressure_0")


@law
def has_air(mode):
    """Return whether the dump valve connects the supply in a mode of the valves."""
    return mode in (MODE_NO.HOLD, MODE_NO.FOLLOW)


@law
def detection_level(state, mode):
    """Return the level of detection: of sensors without air, of motion in a soft start, else all (AIR_LEVEL)."""
    return (MOTION_LEVEL if state == STATE_NO.STARTING else AIR_LEVEL) if has_air(mode) else SENSORS_LEVEL


@composition
def reset_detectors(rows):
    """Reset the memory of the detectors; the estimate of the air, and demands, are kept."""
    for j in range(len(rows.joints)):
        write_numbers(rows.joints[j, JOINT_AT.detectors :], INITIAL_MEMORY)
    write_numbers(rows.memory[RIG_AT.lines :], FIRST_LINES)
    rows.memory[RIG_AT.even] = MIN_EVEN_TIME


@law
def stopping_angle(limits, estimate, plans):
    """Return the angle, rad, at which a joint that stops now is held; NaN where it is unknown.

    With a law that plans its motion it is the angle that braking leads to: a joint that stops at once accelerates the
    others. It is clipped to the working stroke.
    """
    angle, velocity = estimate.averaged_angle, estimate.averaged_velocity
    if plans > 0.0:
        angle = angle + 0.5 * velocity * abs(velocity) / limits.braking
    return min(max(angle, -limits.working), limits.working)


@composition
def hold_joints(rows, at_demands):
    """Set the demands to constant angles: those at which joints are or can stop, or the present ones."""
    for j in range(len(rows.joints)):
        estimate = read_numbers(FIRST_JOINT_MEMORY.estimate, rows.joints[j, JOINT_AT.estimate :])
        demand = read_numbers(FIRST_JOINT_MEMORY.demand, rows.joints[j, JOINT_AT.demand :])
        limits = read_numbers(SETTINGS_TEMPLATE.moving, rows.settings[j, SETTING_AT.moving :])
        held = stopping_angle(limits, estimate, rows.rig[LIMIT_AT.plans])
        hold_joint(rows, j, demand.demand if at_demands else held)


@composition
def hold_joint(rows, j, angle):
    """Set the demand of a joint to a constant angle, rad; where that is not finite, the angle of the demand stays."""
    joint = rows.joints[j]
    held = angle if isfinite(angle) else joint[JOINT_AT.demand]
    joint[JOINT_AT.demand] = joint[JOINT_AT.demand + 1] = held
    joint[JOINT_AT.velocity] = joint[JOINT_AT.acceleration] = 0.0


@composition
def write_voltages_without_air(rows):
    """Write the voltages of the valves by their mode, without air.

    VENT_JOINT vents only faulty joints; CENTRE vents the fuller hose of joints whose valve is unresponsive.
    """
    mode = rows.memory[RIG_AT.mode]
    for j in range(len(rows.joints)):
        fault, at = rows.joints[j, JOINT_AT.latched], LIMIT_AT.vented if mode == MODE_NO.VENT else LIMIT_AT.centre
        if mode == MODE_NO.VENT_JOINT and VENT_JOINT_FROM <= fault < VENT_FROM:
            at = LIMIT_AT.vented
        if mode == MODE_NO.CENTRE and fault == FAULT_NO.VALVE_UNRESPONSIVE:
            # One hose may be burst: the other throws the joint into its stop unless it is vented at once.
            at = LIMIT_AT.voltage_low if rows.joints[j, LAST_PRESSURE_AT] > 0.0 else LIMIT_AT.voltage_high
        volts = rows.rig[at]
        rows.joints[j, JOINT_AT.voltage] = volts
