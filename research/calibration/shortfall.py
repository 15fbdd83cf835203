"""Shortfalls of machines against the paper's findings: 0 where a finding is met with a margin, about 1 where not.

Margins keep noise from deciding: what is asked for here lies inside what a claim allows (claims.toml).
"""

from collections.abc import Mapping
from math import log, radians

import numpy as np

from layflat.arrays import Array
from layflat.experiments.axis_one import OSCILLATION_WINDOW, SETTLING_LIMITS
from layflat.experiments.two_axis import END_TIME, FINAL_BAND, HALF_STEP, LARGE_STEP_TIME, SMALL_STEP_TIME
from layflat.sim.metrics import SETTLING_BAND
from research.calibration.steps import RECORDED_TIME, REST_DURATION, InertiaSteps, PaperSteps, StepResponses

ARRIVAL_BAND = radians(1.5)  # of the unbraked joint about its end
ARRIVAL_TIMES = (2.3, 6.5)  # range for the unbraked joint, s
MAX_OSCILLATION = 0.9  # of the unbraked joint at its end, peak to peak, deg
MAX_OVERSHOOT = 17.0  # of the unbraked joint, deg
MAX_EARLIER_RATIO = 0.45  # settling time of the earlier actuator over the new joint's arrival time
MAX_SETTLING_TIME = 1.35  # of braked joints and the earlier actuator, s
INERTIA_RATIO, INERTIA_RATIO_TOLERANCE = 1.98, 0.22  # of the new joint to the earlier actuator; tolerance of its log
MIN_LOG_LIMIT, MAX_LOG_LIMIT = log(1.1e-2), log(3e-2)  # range of the limits of inertia, log of kg m2 per N m
MAX_BRAKED_LOG_LIMIT = log(8e-2)  # of the limit with the brake, log of kg m2 per N m
MIN_VALUE = 1e-4  # resolution of values, s or rad
EXTRAPOLATION_SLOPE = 0.3  # log of inertia beyond the simulated range for each log of the settling time
MAX_SMALL_MOTION_RATIO = 0.56  # of the earlier actuator's loop height in a small motion to that of the whole stroke
LOOP_HEIGHTS = np.array([25.0, 7.0, 25.0])  # % of torque, section 4.1
LOOP_HEIGHT_TOLERANCES = np.array([1.7, 0.8, 1.7])  # % of torque
MIN_GAIN_RATIO = 1.06  # of a valve's gain with a dither that is too fast for its spool
MIN_PRESSURE_RIPPLE = 600.0  # of the differential pressure, that a converter of 2.4 mbar a count resolves, Pa
MAX_TUNED_OVERSHOOT = 2.0  # of an arm that is tuned by hand, deg
MAX_REST_DISTANCE = 0.16  # between the ends of approaches, deg
DRIFT_TOLERANCE = 0.08  # of the fraction of a drift that the long-term integral compensates
BREAKAWAY_RATIO = 1.2  # of the pressure to that which friction holds, from which a joint moves on
MAX_ARM_SETTLING_TIME = 1.3  # of the arm, s


def settled(error: Array, band: float, cycle: float) -> Array:
    """Return the time after which errors (..., records) stay inside the band, s; infinite unless a second is left."""
    outside = ~(np.abs(error) <= band)
    records = error.shape[-1]
    count = np.where(outside.any(axis=-1), records - np.argmax(outside[..., ::-1], axis=-1), 0)
    return np.where(count * cycle > records * cycle - REST_DURATION, np.inf, count * cycle)


def _times(error: Array, band: float, cycle: float) -> Array:
    """Return settling times; infinite ones become the recorded time plus 1 s for each degree of final rms error."""
    time = settled(error, band, cycle)
    late = np.degrees(np.sqrt(np.mean(np.square(error[..., -round(2 * OSCILLATION_WINDOW / cycle) :]), axis=-1)))
    return np.where(np.isfinite(time), time, error.shape[-1] * cycle + late)


def _swing(error: Array, cycle: float) -> Array:
    """Return peak to peak over the last two seconds, deg."""
    return np.asarray(np.degrees(np.ptp(error[..., -round(OSCILLATION_WINDOW / cycle) :], axis=-1)))


def _over(value: Array | float, most: float | Array) -> Array:
    return np.maximum(0.0, np.subtract(value, most))


def compared(steps: PaperSteps) -> dict[str, Array]:
    """Return the shortfalls against the findings of Fig. 13, (machines,), by name."""
    cycle = steps.cycle
    end = steps.unbraked[..., -round(OSCILLATION_WINDOW / cycle) :].mean(axis=-1, keepdims=True)
    away = steps.unbraked - end
    arrives = _times(away, ARRIVAL_BAND, cycle)
    swing, overshoot = _swing(steps.unbraked, cycle), np.degrees(steps.unbraked.max(axis=-1))
    earlier = _middle(_in_all(steps.earlier, cycle))[:, 0]
    braked = _middle(_in_all(steps.braked, cycle))[:, 0]
    return {
        "unbraked joint arrives too soon": 1.5 * _over(ARRIVAL_TIMES[0] - arrives, 0.0).mean(axis=1),
        "unbraked joint arrives too late": 0.5 * _over(arrives, ARRIVAL_TIMES[1]).mean(axis=1),
        "unbraked joint swings on": 2.5 * np.minimum(_over(swing, MAX_OSCILLATION), 20.0).mean(axis=1),
        "unbraked joint overshoots": 0.1 * _over(overshoot, MAX_OVERSHOOT).mean(axis=1),
        "earlier actuator settles too late": _over(
            earlier, np.minimum(MAX_EARLIER_RATIO * arrives.min(axis=1), MAX_SETTLING_TIME)
        ),
        "braked joint settles too late": _over(braked, MAX_SETTLING_TIME),
    }


def loaded(steps: InertiaSteps) -> dict[str, Array]:
    """Return what is wrong with how much inertia both joints carry: with the brake about twice as much, however asked.

    A limit lies where the time to settle grows beyond what is allowed, or where an oscillation is sustained. There is
    none in the shortest time if the earlier actuator needs more even with the least inertia.
    """
    new, earlier = (_limits_of(one, steps.cycle) for one in (steps.braked, steps.earlier))
    off = _over(np.abs(new - earlier - log(INERTIA_RATIO)), INERTIA_RATIO_TOLERANCE)
    outside = _over(MIN_LOG_LIMIT, earlier) + _over(earlier, MAX_LOG_LIMIT) + _over(new, MAX_BRAKED_LOG_LIMIT)
    without = _over(_middle(_in_all(steps.earlier, steps.cycle))[:, 0], MAX_SETTLING_TIME)
    return {
        "limits are not as one to two": np.asarray(
            3.0 * off.mean(axis=1) + 2.0 * off.max(axis=1) + 3.0 * outside.mean(axis=1) + 2.0 * without
        )
    }


def _limits_of(carried: StepResponses, cycle: float) -> Array:
    """Return logs of the greatest inertia per torque that settles, (machines, windows and without oscillation)."""
    time, swing = _middle(_in_all(carried, cycle)), _middle(carried.swing)
    by_time = _passes(time, np.array(SETTLING_LIMITS), carried.ratios)
    return np.concatenate([by_time, _passes(swing, np.array([2.0 * SETTLING_BAND]), carried.ratios)], axis=1)


def _in_all(carried: StepResponses, cycle: float) -> Array:
    """Times; in place of infinite ones the whole, and a second for each degree of rms error near the end."""
    return np.where(
        np.isfinite(carried.time), carried.time, round(RECORDED_TIME / cycle) * cycle + np.degrees(carried.late)
    )


def _middle(found: Array) -> Array:
    """Return the median over the runs with each inertia, (machines, inertias)."""
    return np.asarray(np.median(found, axis=2))


def _passes(values: Array, levels: Array, ratios: Array) -> Array:
    """Return the logs of inertia at which values (machines, inertias) first pass levels, (machines, levels).

    Outside the range it goes on with the log of the value, so that a search finds its way there.
    """
    logs, top = np.log(ratios), np.maximum.accumulate(np.log(np.maximum(values, MIN_VALUE)), axis=1)[:, None]
    level = np.log(levels)[:, None]
    after = np.clip((top <= level).sum(axis=2, keepdims=True), 1, len(ratios) - 1)
    low, high = (np.take_along_axis(top, place, axis=2) for place in (after - 1, after))
    share = np.where(high > low, (level - low) / np.where(high > low, high - low, 1.0), level >= low)
    between = logs[after - 1] + (logs[after] - logs[after - 1]) * np.clip(share, 0.0, 1.0)
    beyond = np.maximum(level - top[..., -1:], 0.0) - np.maximum(top[..., :1] - level, 0.0)
    return np.asarray(between + EXTRAPOLATION_SLOPE * beyond)[..., 0]


def two_axes(angles: Array, cycle: float) -> dict[str, Array]:
    """Return the shortfalls against section 4.2, (machines,), by name; angles as of `Evidence.arm_moves`."""
    moves = [
        (LARGE_STEP_TIME, SMALL_STEP_TIME, (HALF_STEP, -HALF_STEP)),
        (SMALL_STEP_TIME, END_TIME, (HALF_STEP, HALF_STEP)),
    ]
    demand, final, pushed, beyond = [], [], [], []
    for moved, (begin, until, goals) in enumerate(moves):
        part = angles[:, :, round(begin / cycle) : round(until / cycle)]
        tail = part[:, :, round(0.9 * part.shape[2]) :].mean(axis=2, keepdims=True)
        for joint, goal in enumerate(goals):
            error, own = part[..., joint] - goal, (part - tail)[..., joint]
            demand.append(_times(error, 0.7 * SETTLING_BAND, cycle))
            final.append(_times(own, 0.8 * FINAL_BAND, cycle))
        pushed.append(np.abs(part - part[:, :, :1]).max(axis=2))
        beyond.append(np.degrees(part[..., moved].max(axis=2) - goals[moved]))
    # The small joint's step pushes the large joint, and the reverse.
    large, small = np.degrees(pushed[1][..., 0]), np.degrees(pushed[0][..., 1])
    return {
        "arm settles too late": _over(np.max(demand, axis=0), MAX_ARM_SETTLING_TIME).mean(axis=1),
        "arm does not come to rest": _over(np.max(final, axis=0), MAX_ARM_SETTLING_TIME).mean(axis=1),
        "arm overshoots": 0.3 * _over(np.max(beyond, axis=0), MAX_TUNED_OVERSHOOT).mean(axis=1),
        "large joint is pushed": 2.0 * _over(large / np.maximum(small, 1e-9), 0.3).mean(axis=1),
    }


def comes_back(rests: Array) -> dict[str, Array]:
    """Return the shortfall of repeatability, (machines,); rests as of `Evidence.comes_back`."""
    apart = np.degrees(np.ptp(rests, axis=1))
    return {"arm does not come back": 5.0 * _over(apart, MAX_REST_DISTANCE).sum(axis=1)}


def drift(taken: Array) -> dict[str, Array]:
    """Return the shortfall of the long-term integral in compensating a drift, (machines,)."""
    return {"long-term integral does not learn a drift": 10.0 * _over(np.abs(taken - 1.0), DRIFT_TOLERANCE)}


def small_motions(kept: Array) -> dict[str, Array]:
    """Return the shortfall of the earlier actuator's losses in a small motion, which are to be lower, (machines,)."""
    return {"earlier actuator opposes small motions too much": 10.0 * _over(kept, MAX_SMALL_MOTION_RATIO)}


def dither(ripple: Array) -> dict[str, Array]:
    """Return the shortfall of dither in the pressure, by which the controller detects the air supply, (machines,)."""
    return {
        "dither does not show in the pressure": _over(np.log(MIN_PRESSURE_RIPPLE / np.maximum(ripple, 1.0)), 0.0).mean(
            axis=1
        )
    }


def held_short(values: Mapping[str, Array], frictions: Mapping[str, float]) -> dict[str, Array]:
    """Return the shortfall of joints held by friction where the next phase begins, (machines,).

    In the first two phases nothing is integrated: there the differential pressure is that at which error and pressure
    weigh the same, so that has to be more than what friction holds (Pa, by joint).
    """
    lacking = [
        _over(np.log(BREAKAWAY_RATIO * friction * values[f"{gains}.{phase}.pressure"] / (gain * border)), 0.0)
        for joint, friction in frictions.items()
        for gains in [f"joint.{joint}.gains"]
        for phase, following in (("far", "near"), ("near", "close"))
        for gain, border in [(values[f"{gains}.{phase}.error"], values[f"{gains}.{following}_below.error"])]
    ]
    return {"joint is held short of its goal": np.asarray(np.sum(lacking, axis=0))}


def open_loop(heights: Array) -> dict[str, Array]:
    """Return the shortfall of loop heights against the paper's, (machines,); heights as of `Evidence.hysteresis`."""
    off = _over(np.abs(100.0 * heights - LOOP_HEIGHTS), LOOP_HEIGHT_TOLERANCES).sum(axis=1)
    return {"hysteresis is not the paper's": 0.5 * off}


def spool(gains: Array) -> dict[str, Array]:
    """Return the shortfall of spools that a dither which is too fast has to move less, (machines,)."""
    return {"a fast dither moves the spool as well": 10.0 * _over(MIN_GAIN_RATIO, gains)}
