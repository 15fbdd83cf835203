"""How far machines are from what the paper found: 0 where a finding comes out with a margin, about 1 where not.

Margins keep noise from deciding: what is asked for here lies inside what a claim allows (claims.toml).
"""

from math import radians

import numpy as np

from layflat.arrays import Array
from layflat.experiments.calibration.evidence import RATIOS, Steps
from layflat.experiments.limits import SWING
from layflat.experiments.two_axis import END, FINAL_BAND, FIRST, HALF, SECOND
from layflat.sim.metrics import BAND

CLOSE = radians(1.5)  # the unbraked joint has come to its end within this
REST = 1.0  # a joint has settled if it stays inside for so long, s
ARRIVES = (2.3, 6.5)  # when the unbraked joint comes to its end, s
LEFT = 0.8  # oscillation that it may keep, peak to peak, deg
OVERSHOOTS = 17.0  # deg
SOON = 0.45  # when the earlier actuator has settled, over when the new joint comes to its end
PROMPT = 1.35  # when braked joints and the earlier actuator have settled, s
LIMITS: Array = np.geomspace(1.12e-2, 2.8e-2, 8)  # where the earlier actuator's limit may lie, kg m2 per N m
SHARP = 1.25  # from its limit to so many times as much a joint may do as it likes
BRAKED = (1.9, 2.6)  # a braked joint settles up to so many times that limit, and no more from so many times on
FORGETS = 3.0  # power with which what happens beyond a limit counts less
SWINGS = 0.5  # amplitude that counts as an oscillation, deg
KEPT = 0.56  # share of the earlier actuator's curve that a small motion may keep
STEADY = 1.3  # until when the arm has settled, s


def settled(error: Array, band: float, cycle: float) -> Array:
    """Return the time after which errors (..., records) stay inside the band, s; infinite unless a second is left."""
    outside = ~(np.abs(error) <= band)
    records = error.shape[-1]
    count = np.where(outside.any(axis=-1), records - np.argmax(outside[..., ::-1], axis=-1), 0)
    return np.where(count * cycle > records * cycle - REST, np.inf, count * cycle)


def _finite(time: Array, error: Array, cycle: float) -> Array:
    """Times; in place of infinite ones the whole, and a second for each degree of rms error near the end."""
    late = np.degrees(np.sqrt(np.mean(np.square(error[..., -round(2 * SWING / cycle) :]), axis=-1)))
    return np.where(np.isfinite(time), time, error.shape[-1] * cycle + late)


def _swing(error: Array, cycle: float) -> Array:
    """Peak to peak over the last two seconds, deg."""
    return np.asarray(np.degrees(np.ptp(error[..., -round(SWING / cycle) :], axis=-1)))


def _over(value: Array, most: float | Array) -> Array:
    return np.maximum(0.0, value - most)


def axis_one(steps: Steps) -> dict[str, Array]:
    """Return what each finding of section 4.1 lacks, (machines,), by name."""
    cycle = steps.cycle
    end = steps.unbraked[..., -round(SWING / cycle) :].mean(axis=-1, keepdims=True)
    away = steps.unbraked - end
    arrives = _finite(settled(away, CLOSE, cycle), away, cycle)
    swing, overshoot = _swing(steps.unbraked, cycle), np.degrees(steps.unbraked.max(axis=-1))
    earlier = _finite(settled(steps.earlier, BAND, cycle), steps.earlier, cycle)[:, 0]
    braked = _finite(settled(steps.braked, BAND, cycle), steps.braked, cycle)[:, 0]
    return {
        "unbraked joint arrives too soon": 1.5 * _over(ARRIVES[0] - arrives, 0.0).mean(axis=1),
        "unbraked joint arrives too late": 0.5 * _over(arrives, ARRIVES[1]).mean(axis=1),
        "unbraked joint swings on": 0.7 * np.minimum(_over(swing, LEFT), 20.0).mean(axis=1),
        "unbraked joint overshoots": 0.1 * _over(overshoot, OVERSHOOTS).mean(axis=1),
        "earlier actuator settles too late": _over(earlier, np.minimum(SOON * arrives.min(axis=1), PROMPT)),
        "braked joint settles too late": _over(braked, PROMPT),
        "limits are not as one to two": _limits(steps),
    }


def _limits(steps: Steps) -> Array:
    """What is wrong with both joints over inertia, with the limit of the earlier actuator wherever it fits best."""
    new, earlier = (_settles_and_swings(one, steps.cycle) for one in (steps.carried_braked, steps.carried_earlier))
    least = np.full(len(steps.braked), np.inf)
    for limit in LIMITS:
        wrong = _beside(earlier, limit, SHARP * limit) + _beside(new, BRAKED[0] * limit, BRAKED[1] * limit)
        least = np.minimum(least, 3.0 * wrong)
    return least


def _beside(found: tuple[Array, Array], low: float, high: float) -> Array:
    """What is wrong with a joint that is to settle up to an inertia, and to oscillate from another one on.

    Far beyond its limit it counts less what a joint does: the paper looked for the limit from below.
    """
    settles, swings = found
    weights = np.where(high <= RATIOS, (high / RATIOS) ** FORGETS, 0.0)
    return settles[:, low >= RATIOS].mean(axis=1) + swings @ weights / weights.sum()


def _settles_and_swings(error: Array, cycle: float) -> tuple[Array, Array]:
    """By inertia: what is wrong with a joint that is to settle, and with one that is to go on oscillating."""
    time, amplitude = settled(error, BAND, cycle), 0.5 * _swing(error, cycle)
    comes = np.isfinite(time)
    late = np.minimum(_over(np.where(comes, time, 0.0), PROMPT) / 3.0, 1.0)
    settles = np.where(comes, late, 1.0 + np.minimum(amplitude / 10.0, 1.0))
    too_soon = np.where(comes, 0.2 + _over(6.0 - np.where(comes, time, 0.0), 0.0) / 20.0, 0.0)
    return settles, _over(1.0 - amplitude / SWINGS, 0.0) + too_soon


def two_axes(angles: Array, cycle: float) -> dict[str, Array]:
    """Return what the findings of section 4.2 lack, (machines,), by name; angles as of `Evidence.arm_moves`."""
    moves = [(FIRST, SECOND, (HALF, -HALF)), (SECOND, END, (HALF, HALF))]
    demand, final, pushed = [], [], []
    for begin, until, goals in moves:
        part = angles[:, :, round(begin / cycle) : round(until / cycle)]
        tail = part[:, :, round(0.9 * part.shape[2]) :].mean(axis=2, keepdims=True)
        for joint, goal in enumerate(goals):
            error, own = part[..., joint] - goal, (part - tail)[..., joint]
            demand.append(_finite(settled(error, 0.7 * BAND, cycle), error, cycle))
            final.append(_finite(settled(own, 0.8 * FINAL_BAND, cycle), own, cycle))
        pushed.append(np.abs(part - part[:, :, :1]).max(axis=2))
    # The small joint's step pushes the large joint, and the reverse.
    large, small = np.degrees(pushed[1][..., 0]), np.degrees(pushed[0][..., 1])
    return {
        "arm settles too late": _over(np.max(demand, axis=0), STEADY).mean(axis=1),
        "arm does not come to rest": _over(np.max(final, axis=0), STEADY).mean(axis=1),
        "large joint is pushed": 2.0 * _over(large / np.maximum(small, 1e-9), 0.3).mean(axis=1),
    }


def small_motions(kept: Array) -> dict[str, Array]:
    """Return what the earlier actuator lacks in a small motion, which its losses are to oppose less, (machines,)."""
    return {"earlier actuator opposes small motions too much": 10.0 * _over(kept, KEPT)}
