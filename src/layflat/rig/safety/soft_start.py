"""Soft start of a rig as compiled code: the first reading, and the air that comes; functions take `CycleRows`."""

# mypy: disable-error-code="no-untyped-def"

from math import inf, isfinite

from layflat.jit import composition
from layflat.lanes import read_numbers, write_numbers
from layflat.physics.air_balance import AirEstimate
from layflat.physics.joint import REST_PRESSURE_RATIO
from layflat.rig.named import offset_of
from layflat.rig.safety.cycle_numbers import (
    FIRST_JOINT_MEMORY,
    INPUT_AT,
    JOINT_AT,
    LIMIT_AT,
    RIG_AT,
    SAMPLE_AT,
    SETTINGS_TEMPLATE,
)
from layflat.rig.safety.holding import hold_joint

AIR_READY_TIME = 0.2  # for which supply and ripple have to be sufficient before a soft start is over, s
FILL_TIME_FRACTION = 0.7  # of start_time, after which filled hoses are no longer required: valves may leak too little
# Of the supply's gauge pressure; joints with less are compliant, and accelerate each other further.
MIN_FILL_FRACTION = 0.4
RIPPLE_AT = offset_of(FIRST_JOINT_MEMORY, "detectors.trace.ripple")
MIN_RIPPLE_AT = offset_of(SETTINGS_TEMPLATE, "detectors.valve_unresponsive.ripple")


@composition
def begin_reading(rows, filled):
    """Begin with the first reading: the air in the hoses, and demands at the present angles.

    `filled` is 1 where the hoses hold the pressure that they settle to with centred valves; else they are empty.
    """
    empty = rows.rig[LIMIT_AT.ambient]
    held = max(REST_PRESSURE_RATIO * rows.inputs[INPUT_AT.supply], empty) if filled > 0.0 else empty
    for j in range(len(rows.joints)):
        angle, pressure = rows.samples[j, SAMPLE_AT.angle], rows.samples[j, SAMPLE_AT.pressure]
        half = 0.5 * pressure if isfinite(pressure) else 0.0
        write_numbers(rows.joints[j, JOINT_AT.air :], AirEstimate(held + half, held - half, angle, 0.0, 0.0))
        hold_joint(rows, j, angle)
    rows.memory[RIG_AT.begun] = 1.0


@composition
def _has_air(rows):
    """Return whether the supply suffices, and every joint has the ripple of air.

    Where the ripple of a joint can't be detected, the supply alone counts.
    """
    known, ripples = True, True
    for j in range(len(rows.joints)):
        least, ripple = rows.settings[j, MIN_RIPPLE_AT], rows.joints[j, RIPPLE_AT]
        known = known and least > 0.0
        ripples = ripples and least < ripple < inf
    return rows.inputs[INPUT_AT.supply] >= rows.rig[LIMIT_AT.ready] and (ripples or not known)


@composition
def _are_hoses_filled(rows):
    """Return whether every joint's hoses hold, on average, `MIN_FILL_FRACTION` of the supply's gauge pressure."""
    empty, filled = rows.rig[LIMIT_AT.ambient], True
    least = 2.0 * (empty + MIN_FILL_FRACTION * (rows.inputs[INPUT_AT.supply] - empty))
    for j in range(len(rows.joints)):
        air = read_numbers(FIRST_JOINT_MEMORY.air, rows.joints[j, JOINT_AT.air :])
        filled = filled and air.pressure_a + air.pressure_b >= least
    return filled


@composition
def update_air_time(rows):
    """Update the time for which the air has been sufficient."""
    memory = rows.memory
    memory[RIG_AT.air_time] = memory[RIG_AT.air_time] + rows.inputs[INPUT_AT.elapsed] if _has_air(rows) else 0.0


@composition
def has_air_come(rows):
    """Return whether a soft start is over: sufficient air for `AIR_READY_TIME`, and filled hoses.

    These are not required once `FILL_TIME_FRACTION` of the time of a start has passed.
    """
    patient = rows.memory[RIG_AT.in_state] > FILL_TIME_FRACTION * rows.rig[LIMIT_AT.start_time]
    return rows.memory[RIG_AT.air_time] >= AIR_READY_TIME and (patient or _are_hoses_filled(rows))
