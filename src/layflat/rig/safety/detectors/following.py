"""Detector of a joint that lags behind its demand, or hardly moves although it has most of the supply's pressure."""

from math import nan
from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import AIR_LEVEL, accumulate_time
from layflat.rig.safety.faults import Fault

FOLLOWING_FAULT = int(Fault.FOLLOWING_ERROR)
# A joint with at least this error (rad) and this fraction of the supply's gauge pressure that is slower than this
# (rad/s) for this time (s) is held back: a free one would exceed that speed within hundredths of a second.
HELD_BACK_ERROR, HELD_BACK_PRESSURE, HELD_BACK_SPEED, HELD_BACK_TIME = 0.09, 0.6, 0.35, 0.3
EXPLAINED_TIME_RATIO = 0.25  # weight of time in which another, braking joint explains it: it may do so for 0.15 s


class FollowingLimits(NamedTuple):
    """Limits of the detector of a following error."""

    error: float  # of a stationary joint, rad
    time: float  # additional error per speed, s
    demand_speed: float  # of the expected angle, rad/s
    error_time: float  # time for which the error may be too large, s
    held_back_pressure: float  # differential pressure with which no free joint is slow, Pa
    held_back_time: float = HELD_BACK_TIME  # time for which a joint may be slow in spite of it, s


class FollowingMemory(NamedTuple):
    """Memory of the detector: the expected angle, and times of too large an error."""

    expected_angle: float = nan  # expected angle, rad; NaN at first
    error_time: float = 0.0  # time for which the joint has been too far from it, s
    held_back_time: float = 0.0  # time for which it has been slow in spite of its pressure, s


@law
def advance_expected_angle(limits, expected_angle, angle, demand, elapsed):
    """Return a joint's expected angle, rad: it moves to the demand with `demand_speed`, or as the joint, if faster.

    So a step of the demand is no error, nor is a joint that is ahead.
    """
    step = limits.demand_speed * elapsed
    start = expected_angle if expected_angle == expected_angle else angle  # noqa: PLR0124  # NaN: none yet
    return min(max(start + step, angle), demand) if demand >= start else max(min(start - step, angle), demand)


@law
def allowed_error(limits, velocity, lead):
    """Return the greatest error of a joint without a fault, rad; `lead`: greatest lead of any demand, rad."""
    return limits.error + limits.time * abs(velocity) + lead


@law
def find_following_error(limits, memory, sample):
    """Return the memory after a sample, and FOLLOWING_FAULT or 0.

    The fault is set once either condition has lasted for its time: the joint is farther from its expected angle than
    `allowed_error`; or it is nearly stationary in spite of its differential pressure and its distance to the demand.
    The second time counts a quarter while another, braking joint explains it.
    """
    is_pressurised = sample.level >= AIR_LEVEL
    expected_angle = (
        advance_expected_angle(limits, memory.expected_angle, sample.angle, sample.demand, sample.elapsed)
        if is_pressurised
        else nan
    )
    error = abs(sample.angle - expected_angle)
    error_time = accumulate_time(
        memory.error_time,
        is_pressurised and error > allowed_error(limits, sample.velocity, sample.lead),
        sample.elapsed,
    )
    has_error = is_pressurised and abs(sample.angle - sample.demand) > HELD_BACK_ERROR
    p = sample.averaged_pressure
    is_held_back = has_error and abs(p) > limits.held_back_pressure and abs(sample.velocity) < HELD_BACK_SPEED
    # Another joint that brakes may hold this one for a while.
    is_unexplained = min(abs(p - sample.others_light), abs(p - sample.others_heavy)) > limits.held_back_pressure
    held_back_time = accumulate_time(
        memory.held_back_time, is_held_back, sample.elapsed if is_unexplained else EXPLAINED_TIME_RATIO * sample.elapsed
    )
    return FollowingMemory(
        expected_angle, error_time, held_back_time
    ), FOLLOWING_FAULT if error_time >= limits.error_time or held_back_time >= limits.held_back_time else 0
