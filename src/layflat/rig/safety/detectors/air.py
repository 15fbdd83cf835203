"""Detectors of air that contradicts the valve's command, and of sensors that may be frozen, which then explain it."""

from math import inf, isfinite
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.air_balance import RESIDUAL_SMOOTHING_TIME
from layflat.rig.safety.detectors.sample import AIR_LEVEL, accumulate_time
from layflat.rig.safety.faults import Fault

PRESSURE_FROZEN, VALVE_UNRESPONSIVE = int(Fault.PRESSURE_FROZEN), int(Fault.VALVE_UNRESPONSIVE)
MIN_STIR_TIME = 0.02  # of a residual around a stationary joint that is motion; that of a burst hose is wrong by then, s
MOTION_COUNTS = 2.5  # counts from one sample to the next that are motion, not noise
DITHER_PRESSURE_FRACTION = 0.6  # of the supply's gauge pressure, up to which air flows enough for dither to show


class SuspicionLimits(NamedTuple):
    """Limits beyond which a sensor or the air is suspect."""

    grain: float  # one count of the angle's converter, or noise if that is more, rad
    lively: float  # 1 if a valid pressure sensor changes in every sample, else 0
    residual: float  # of air, as an opening of the valve; infinite where there is no balance: a joint of one hose
    doubtful: float  # time of the same sample after which a sensor may be frozen, s
    warmth: float = 0.0  # residual per speed of air that keeps the heat of its compression; 0: joints are slow, s/rad
    filling: float = 0.0  # residual per opening of the valve of air that keeps the heat of its inflow, 1
    still: float = inf  # residual of a stationary joint, in addition to that of filling


class FrozenPressureLimits(NamedTuple):
    """Times for which a pressure sensor may report the same count, s."""

    patience: float  # in any case
    sure: float  # where a sensor is suspect


class ValveResponseLimits(NamedTuple):
    """Limits of the detector of an unresponsive valve."""

    ripple: float  # amplitude below which there is no air (controller's rule 1), Pa; zero where no dither is seen
    patience: float  # how long the ripple may be gone, s
    shows: float  # differential pressure up to which there is a ripple, Pa
    uncut: float  # opening up to which the spool has room for its dither


class SuspicionMemory(NamedTuple):
    """Memory of the suspicions about a joint's sensors and air."""

    same_pressure: float = 0.0  # time for which the pressure has been the same, s
    suspect: float = 0.0  # 1 where a sensor is suspect, else 0
    speed: float = 0.0  # of the joint, averaged as the residual is, rad/s
    opening: float = 0.0  # of its valve, likewise
    stirs: float = 0.0  # time for which its air has moved although the joint is stationary, s


class SensorSuspicion(NamedTuple):
    """Suspicions of a cycle."""

    angle: bool  # the angle is constant although the joint moved before
    any: bool  # the angle or the pressure may be frozen
    wrong: bool  # the air contradicts the valve's command, or a sensor is wrong
    suspect: bool  # a sensor may be frozen, and the air has been wrong since
    moves: bool  # by its air the joint moves, while its angle is constant


@law
def average_like_residual(before, value, elapsed):
    """Return a value averaged as the residual (`RESIDUAL_SMOOTHING_TIME`); one that is not finite is ignored."""
    after = before + min(elapsed / RESIDUAL_SMOOTHING_TIME, 1.0) * (value - before)
    return after if isfinite(after) else before


@law
def update_suspicion(limits, memory, before, now, sample):
    """Return `SuspicionMemory` and `SensorSuspicion` after a sample.

    A sensor that is suspect stays so, without wrong air too, as long as it repeats its samples.

    Args: limits; memory; traces before and after the sample; `JointSample`.
    """
    airy = sample.level >= AIR_LEVEL
    repeated = airy and limits.lively > 0.0 and sample.pressure == before.pressure_1
    same_pressure = accumulate_time(memory.same_pressure, repeated, sample.elapsed)
    angle = now.same_angle > limits.doubtful and now.step > MOTION_COUNTS * limits.grain
    either = same_pressure > limits.doubtful or angle
    speed = average_like_residual(memory.speed, sample.velocity, sample.elapsed)
    opening = average_like_residual(memory.opening, sample.opening, sample.elapsed)
    # The isothermal balance predicts less pressure in a hose that a joint compresses, or that is filled, than there is.
    warm, filled = -limits.warmth * speed, limits.filling * opening
    upper, lower = max(warm, 0.0) + max(filled, 0.0), min(warm, 0.0) + min(filled, 0.0)
    beyond = sample.residual > limits.residual + upper or sample.residual < lower - limits.residual
    wrong = airy and sample.alone > 0.0 and beyond
    suspect = either and (wrong or memory.suspect > 0.0)
    stirred = abs(sample.residual) > limits.still + limits.filling * abs(opening)
    stands = airy and sample.alone > 0.0 and now.same_angle > limits.doubtful
    stirs = accumulate_time(memory.stirs, stands and stirred, sample.elapsed)
    after = SuspicionMemory(same_pressure, 1.0 if suspect else 0.0, speed, opening, stirs)
    return after, SensorSuspicion(angle, either, wrong, suspect, stirs > MIN_STIR_TIME)


@law
def find_pressure_frozen(limits, same_pressure, suspect):
    """Return PRESSURE_FROZEN if a pressure has been the same for too long (s), less long if it is suspect, else 0."""
    return PRESSURE_FROZEN if same_pressure >= limits.patience or (suspect and same_pressure > limits.sure) else 0


@law
def find_valve_unresponsive(limits, before, doubts, blocked, now, sample):
    """Return the time without a ripple after a sample (s), and VALVE_UNRESPONSIVE or 0.

    It is a fault if the ripple has been gone for `limits.patience`, or the air is wrong while no sensor is suspect: a
    stuck spool, a burst or a kinked hose. `blocked` excuses wrong air, but no missing ripple.

    Args: limits; time without a ripple `before`, s, which goes on only while a ripple should show (small averaged
    pressure and opening), and is 0 once there is one; `SensorSuspicion`; whether the joint is blocked; trace `now`
    after the sample; `JointSample`.
    """
    shows = abs(sample.averaged_pressure) < limits.shows and abs(sample.opening) < limits.uncut
    gone = sample.level >= AIR_LEVEL and sample.alone > 0.0 and now.ripple < limits.ripple
    quiet = accumulate_time(before, gone, sample.elapsed if shows else 0.0)
    wrong = doubts.wrong and not doubts.any and not blocked
    return quiet, VALVE_UNRESPONSIVE if wrong or quiet >= limits.patience else 0
