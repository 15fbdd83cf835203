"""How far machines are from what the paper found: 0 where a finding comes out with a margin, about 1 where not.

Margins keep noise from deciding: what is asked for here lies inside what a claim allows (claims.toml).
"""

from collections.abc import Mapping
from math import log, radians

import numpy as np

from layflat.arrays import Array
from layflat.experiments.axis_one import SWING, WINDOWS
from layflat.experiments.two_axis import END, FINAL_BAND, FIRST, HALF, SECOND
from layflat.sim.metrics import BAND
from research.calibration.steps import REST, WATCHED, Carried, Compared, Loaded

CLOSE = radians(1.5)  # the unbraked joint has come to its end within this
ARRIVES = (2.3, 6.5)  # when the unbraked joint comes to its end, s
LEFT = 0.9  # oscillation that it may keep, peak to peak, deg
OVERSHOOTS = 17.0  # deg
SOON = 0.45  # when the earlier actuator has settled, over when the new joint comes to its end
PROMPT = 1.35  # when braked joints and the earlier actuator have settled, s
TWICE, NEAR = 1.98, 0.22  # how many times as much the new joint carries, and how far off its log may be
LEAST, MOST, MOST_BRAKED = log(1.1e-2), log(3e-2), log(8e-2)  # where the limits may lie, log of kg m2 per N m
LITTLE = 1e-4  # values are not told apart below this, s or rad
BEYOND = 0.3  # logs of inertia by which a limit lies outside the range looked at, for each log of the time to settle
KEPT = 0.56  # share of the earlier actuator's curve that a small motion may keep
HEIGHTS, WITHIN = np.array([25.0, 7.0, 25.0]), np.array([1.7, 0.8, 1.7])  # % of torque, section 4.1
FASTER = 1.06  # times as much a valve lets through with a dither that is too fast for its spool
RIPPLE = 600.0  # dither in the differential pressure that a converter of 2.4 mbar a count shows beyond doubt, Pa
BEYOND_GOAL = 2.0  # overshoot that who tunes an arm by hand leaves, deg
APART = 0.16  # how far apart approaches may end, deg
TAKEN = 0.08  # how far off the share of a drift may be that the long-term integral takes over
BREAKS_LOOSE = 1.2  # times the pressure that friction holds: a joint moves on
STEADY = 1.3  # until when the arm has settled, s


def settled(error: Array, band: float, cycle: float) -> Array:
    """Return the time after which errors (..., records) stay inside the band, s; infinite unless a second is left."""
    outside = ~(np.abs(error) <= band)
    records = error.shape[-1]
    count = np.where(outside.any(axis=-1), records - np.argmax(outside[..., ::-1], axis=-1), 0)
    return np.where(count * cycle > records * cycle - REST, np.inf, count * cycle)


def _times(error: Array, band: float, cycle: float) -> Array:
    """Times to settle; in place of infinite ones the whole, and a second for each degree of rms error near the end."""
    time = settled(error, band, cycle)
    late = np.degrees(np.sqrt(np.mean(np.square(error[..., -round(2 * SWING / cycle) :]), axis=-1)))
    return np.where(np.isfinite(time), time, error.shape[-1] * cycle + late)


def _swing(error: Array, cycle: float) -> Array:
    """Peak to peak over the last two seconds, deg."""
    return np.asarray(np.degrees(np.ptp(error[..., -round(SWING / cycle) :], axis=-1)))


def _over(value: Array | float, most: float | Array) -> Array:
    return np.maximum(0.0, np.subtract(value, most))


def compared(steps: Compared) -> dict[str, Array]:
    """Return what each finding of Fig. 13 lacks, (machines,), by name."""
    cycle = steps.cycle
    end = steps.unbraked[..., -round(SWING / cycle) :].mean(axis=-1, keepdims=True)
    away = steps.unbraked - end
    arrives = _times(away, CLOSE, cycle)
    swing, overshoot = _swing(steps.unbraked, cycle), np.degrees(steps.unbraked.max(axis=-1))
    earlier = _middle(_in_all(steps.earlier, cycle))[:, 0]
    braked = _middle(_in_all(steps.braked, cycle))[:, 0]
    return {
        "unbraked joint arrives too soon": 1.5 * _over(ARRIVES[0] - arrives, 0.0).mean(axis=1),
        "unbraked joint arrives too late": 0.5 * _over(arrives, ARRIVES[1]).mean(axis=1),
        "unbraked joint swings on": 2.5 * np.minimum(_over(swing, LEFT), 20.0).mean(axis=1),
        "unbraked joint overshoots": 0.1 * _over(overshoot, OVERSHOOTS).mean(axis=1),
        "earlier actuator settles too late": _over(earlier, np.minimum(SOON * arrives.min(axis=1), PROMPT)),
        "braked joint settles too late": _over(braked, PROMPT),
    }


def loaded(steps: Loaded) -> dict[str, Array]:
    """Return what is wrong with how much inertia both joints carry: with the brake about twice as much, however asked.

    A limit lies where the time to settle grows beyond what is allowed, or where an oscillation is sustained. There is
    none in the shortest time if the earlier actuator needs more even with the least inertia.
    """
    new, earlier = (_limits_of(one, steps.cycle) for one in (steps.braked, steps.earlier))
    off = _over(np.abs(new - earlier - log(TWICE)), NEAR)
    outside = _over(LEAST, earlier) + _over(earlier, MOST) + _over(new, MOST_BRAKED)
    without = _over(_middle(_in_all(steps.earlier, steps.cycle))[:, 0], PROMPT)
    return {
        "limits are not as one to two": np.asarray(
            3.0 * off.mean(axis=1) + 2.0 * off.max(axis=1) + 3.0 * outside.mean(axis=1) + 2.0 * without
        )
    }


def _limits_of(carried: Carried, cycle: float) -> Array:
    """Logs of the greatest inertia per torque that a joint carries, (machines, windows and without oscillation)."""
    time, swing = _middle(_in_all(carried, cycle)), _middle(carried.swing)
    by_time = _passes(time, np.array(WINDOWS), carried.ratios)
    return np.concatenate([by_time, _passes(swing, np.array([2.0 * BAND]), carried.ratios)], axis=1)


def _in_all(carried: Carried, cycle: float) -> Array:
    """Times; in place of infinite ones the whole, and a second for each degree of rms error near the end."""
    return np.where(np.isfinite(carried.time), carried.time, round(WATCHED / cycle) * cycle + np.degrees(carried.late))


def _middle(found: Array) -> Array:
    """The median over the runs with each inertia, (machines, inertias)."""
    return np.asarray(np.median(found, axis=2))


def _passes(values: Array, levels: Array, ratios: Array) -> Array:
    """Return the logs of inertia at which values (machines, inertias) first pass levels, (machines, levels).

    Outside the range it goes on with the log of the value, so that a search finds its way there.
    """
    logs, top = np.log(ratios), np.maximum.accumulate(np.log(np.maximum(values, LITTLE)), axis=1)[:, None]
    level = np.log(levels)[:, None]
    after = np.clip((top <= level).sum(axis=2, keepdims=True), 1, len(ratios) - 1)
    low, high = (np.take_along_axis(top, place, axis=2) for place in (after - 1, after))
    share = np.where(high > low, (level - low) / np.where(high > low, high - low, 1.0), level >= low)
    between = logs[after - 1] + (logs[after] - logs[after - 1]) * np.clip(share, 0.0, 1.0)
    beyond = np.maximum(level - top[..., -1:], 0.0) - np.maximum(top[..., :1] - level, 0.0)
    return np.asarray(between + BEYOND * beyond)[..., 0]


def two_axes(angles: Array, cycle: float) -> dict[str, Array]:
    """Return what the findings of section 4.2 lack, (machines,), by name; angles as of `Evidence.arm_moves`."""
    moves = [(FIRST, SECOND, (HALF, -HALF)), (SECOND, END, (HALF, HALF))]
    demand, final, pushed, beyond = [], [], [], []
    for moved, (begin, until, goals) in enumerate(moves):
        part = angles[:, :, round(begin / cycle) : round(until / cycle)]
        tail = part[:, :, round(0.9 * part.shape[2]) :].mean(axis=2, keepdims=True)
        for joint, goal in enumerate(goals):
            error, own = part[..., joint] - goal, (part - tail)[..., joint]
            demand.append(_times(error, 0.7 * BAND, cycle))
            final.append(_times(own, 0.8 * FINAL_BAND, cycle))
        pushed.append(np.abs(part - part[:, :, :1]).max(axis=2))
        beyond.append(np.degrees(part[..., moved].max(axis=2) - goals[moved]))
    # The small joint's step pushes the large joint, and the reverse.
    large, small = np.degrees(pushed[1][..., 0]), np.degrees(pushed[0][..., 1])
    return {
        "arm settles too late": _over(np.max(demand, axis=0), STEADY).mean(axis=1),
        "arm does not come to rest": _over(np.max(final, axis=0), STEADY).mean(axis=1),
        "arm overshoots": 0.3 * _over(np.max(beyond, axis=0), BEYOND_GOAL).mean(axis=1),
        "large joint is pushed": 2.0 * _over(large / np.maximum(small, 1e-9), 0.3).mean(axis=1),
    }


def comes_back(rests: Array) -> dict[str, Array]:
    """Return what arms lack that come to one place again and again, (machines,); rests as of `Evidence.comes_back`."""
    apart = np.degrees(np.ptp(rests, axis=1))
    return {"arm does not come back": 5.0 * _over(apart, APART).sum(axis=1)}


def drift(taken: Array) -> dict[str, Array]:
    """Return what long-term integrals lack that are to take over a drift, (machines,)."""
    return {"long-term integral does not learn a drift": 10.0 * _over(np.abs(taken - 1.0), TAKEN)}


def small_motions(kept: Array) -> dict[str, Array]:
    """Return what the earlier actuator lacks in a small motion, which its losses are to oppose less, (machines,)."""
    return {"earlier actuator opposes small motions too much": 10.0 * _over(kept, KEPT)}


def dither(ripple: Array) -> dict[str, Array]:
    """Return what dither lacks in the pressure, by which the controller knows that there is air, (machines,)."""
    return {"dither does not show in the pressure": _over(np.log(RIPPLE / np.maximum(ripple, 1.0)), 0.0).mean(axis=1)}


def held_short(values: Mapping[str, Array], frictions: Mapping[str, float]) -> dict[str, Array]:
    """Return what joints lack to get through their phases, (machines,): friction holds them where the next begins.

    In the first two phases nothing is integrated: there the differential pressure is that at which error and pressure
    weigh the same, so that has to be more than what friction holds (Pa, by joint).
    """
    lacking = [
        _over(np.log(BREAKS_LOOSE * friction * values[f"{gains}.{phase}.pressure"] / (gain * border)), 0.0)
        for joint, friction in frictions.items()
        for gains in [f"joint.{joint}.gains"]
        for phase, following in (("far", "near"), ("near", "close"))
        for gain, border in [(values[f"{gains}.{phase}.error"], values[f"{gains}.{following}_below.error"])]
    ]
    return {"joint is held short of its goal": np.asarray(np.sum(lacking, axis=0))}


def open_loop(heights: Array) -> dict[str, Array]:
    """Return what curves lack of the paper's heights, (machines,); heights as of `Evidence.hysteresis`."""
    off = _over(np.abs(100.0 * heights - HEIGHTS), WITHIN).sum(axis=1)
    return {"hysteresis is not the paper's": 0.5 * off}


def spool(gains: Array) -> dict[str, Array]:
    """Return what spools lack that a dither which is too fast moves less, (machines,)."""
    return {"a fast dither moves the spool as well": 10.0 * _over(FASTER, gains)}
