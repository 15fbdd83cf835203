"""Detectors of samples beyond a bound: a joint's angle, speed and pressure, and the supply of the whole machine."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import AIR_LEVEL, MOTION_LEVEL, accumulate_time, count_samples
from layflat.rig.safety.faults import Fault

RAIL_FAULT, RAIL_SAMPLES = int(Fault.ANGLE_AT_RAIL), Fault.ANGLE_AT_RAIL.cycles
PRESSURE_FAULT, PRESSURE_SAMPLES = int(Fault.OVER_PRESSURE), Fault.OVER_PRESSURE.cycles
SPEED_FAULT, SPEED_SAMPLES = int(Fault.OVER_SPEED), Fault.OVER_SPEED.cycles
STROKE_FAULT, STROKE_SAMPLES = int(Fault.OUTSIDE_STROKE), Fault.OUTSIDE_STROKE.cycles
SUPPLY_FAULT = int(Fault.SUPPLY_LOST)
NOT_YET_INSIDE = (
    -1.0
)  # of a joint that has not been inside since the air was brought; less by each sample past its stop
LOW_SUPPLY_SAMPLES = (
    3  # samples of low pressure after which a supply is lost: as long as valves are open, hoses empty into its line
)


class RailLimits(NamedTuple):
    """Angles at or beyond which the sensor is at its rail: open or shorted, at an end of its converter's range, rad."""

    low: float
    high: float


class StrokeLimits(NamedTuple):
    """Limits of the angle from mid-stroke, rad."""

    stroke: float  # beyond which a joint is outside
    rests: float  # up to which it may rest without air; from there the controller moves it inside
    inside: float  # up to which it has arrived inside
    thrown: float  # additional samples allowed beyond `rests`: other joints may throw it to its stop


class SupplyLimits(NamedTuple):
    """Limits of the supply."""

    low: float  # absolute, Pa, as the next
    high: float
    patience: float  # time for which the ripple of all of several joints may be gone, s


class SupplyMemory(NamedTuple):
    """Memory of the supply's detector."""

    above: float = 0.0  # successive samples above the upper limit
    below: float = 0.0  # successive samples below the lower one
    still: float = 0.0  # time for which no joint has had a ripple, s


@law
def is_between_rails(limits, angle):
    """Return whether an angle (rad) lies between the rails."""
    return limits.low < angle < limits.high


@law
def find_rail(limits, before, sample):
    """Return the count of successive samples at the rail, with or without air, and the fault."""
    run = count_samples(before, not is_between_rails(limits, sample.angle))
    return run, RAIL_FAULT if run >= RAIL_SAMPLES else 0


@law
def find_over_pressure(limit, before, sample):
    """Return the count of successive samples whose differential pressure exceeds +-limit (Pa), and the fault."""
    run = count_samples(before, not (-limit < sample.pressure < limit))
    return run, PRESSURE_FAULT if run >= PRESSURE_SAMPLES else 0


@law
def find_over_speed(limit, before, rails, trace, sample):
    """Return the count of successive samples faster than a limit (rad/s), of a sensor off its rails, and the fault.

    `trace` is that before the sample.
    """
    step = abs(sample.angle - trace.angle)
    # For a joint that accelerates, the mean speed since the last sample lags by half a cycle.
    gained = 0.5 * (step - trace.step)
    speed = (step + (gained if gained > 0.0 else 0.0)) / sample.elapsed
    both_sound = is_between_rails(rails, sample.angle) and is_between_rails(rails, trace.angle)
    run = count_samples(before, sample.level >= MOTION_LEVEL and both_sound and speed > limit)
    return run, SPEED_FAULT if run >= SPEED_SAMPLES else 0


@law
def find_outside(limits, before, rails, sample):
    """Return the count of successive samples beyond the working stroke on either side, and the fault.

    Beyond the stroke comes the sensor's rail: a joint that gets there is still outside. Without air, gravity, a fault
    or a hand moves joints to their stops; until the controller has moved them inside, the limit is `rests`, and the
    count is negative.
    """
    turned, at_work = abs(sample.angle), is_between_rails(rails, sample.angle)
    led = before < 0.0 and turned > limits.inside
    known = NOT_YET_INSIDE - before if led else max(before, 0.0)
    beyond = turned > (limits.rests if led else limits.stroke) if at_work else known > 0.0
    run = count_samples(known, sample.level >= MOTION_LEVEL and beyond)
    found = run >= STROKE_SAMPLES + (limits.thrown if led else 0.0)
    return NOT_YET_INSIDE - run if led else run, STROKE_FAULT if found else 0


@law
def find_supply(limits, memory, supply, all_still, elapsed, level):
    """Return memory and fault of the supply (absolute, Pa): PRESSURE_FAULT if too high, SUPPLY_FAULT if lost, else 0.

    It is lost when it is low, or when all of several joints lack a ripple. PRESSURE_FAULT comes first.
    """
    above = count_samples(memory.above, not supply < limits.high)
    if above >= PRESSURE_SAMPLES:
        return SupplyMemory(above, memory.below, memory.still), PRESSURE_FAULT
    below = count_samples(memory.below, level >= AIR_LEVEL and supply < limits.low)
    still = accumulate_time(memory.still, level >= AIR_LEVEL and all_still, elapsed)
    return SupplyMemory(
        above, below, still
    ), SUPPLY_FAULT if still >= limits.patience or below >= LOW_SUPPLY_SAMPLES else 0
