"""The least number of control cycles after which a tip can stay at its goal: openings by sequential least squares.

For a number of cycles N what is least is the sum over all later cycles of the squared excess of the tip's error over
a little less than the band. Where that can be brought to nothing N is reached, and a smaller one is tried.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from layflat.arrays import Array
from layflat.experiments.beyond.least_excess import least_excess
from layflat.experiments.beyond.shooting import Shooting, settled

INSIDE = 0.95  # share of the band that is aimed for
TAIL = 40  # cycles that are looked at after N
LATE = 6  # cycles after N in which openings are sought; the valves are centred from there on
DENSE, SPARSE = 12, 3  # every one of the first cycles after N counts, then every third
FIRST_WEIGHT, LAST_WEIGHT = 30.0, 1e6  # of squared changes of openings, beside errors in halves of the band
WEIGHTS = 10.0 ** np.arange(-2, 3)  # that are tried side by side, over the last good one
HEAVIER = 30.0  # times as much weight where none of them was good
CORRECTIONS = 3  # steps with the same sensitivities after the first
ITERATIONS = 14
STALLED = 0.8  # share of the excess that two iterations must leave at most
STRIDE = 4  # cycles by which N falls at first


@dataclass(frozen=True)
class Trial:
    """Openings with what comes of them.

    Args:
        shooting: the step.
        openings: -1..1, (cycles, joints).
        errors: of the tip at the end of each cycle, m, (cycles, 2).
        free: cycles whose openings are sought.
        band: in which the tip has to stay, m.
    """

    shooting: Shooting
    openings: Array
    errors: Array
    free: int
    band: float

    @cached_property
    def sensitivities(self) -> Array:
        """Changes of the errors with the free openings, m, (cycles, 2, free * joints)."""
        found = self.shooting.sensitivities(self.openings, self.free)
        return np.ascontiguousarray(np.moveaxis(found.reshape(-1, *self.errors.shape), 0, -1))

    @property
    def settled(self) -> int:
        """After how many cycles the tip stays in its band."""
        return int(settled(self.errors, self.band))

    def excess(self, cycles: int) -> float:
        """Return the sum of squared excesses after so many cycles, in halves of the band."""
        return float(excess(self.errors, cycles, self.band))


def excess(errors: Array, cycles: int, band: float) -> Array:
    """Return the sums of squared excesses after so many cycles, in halves of the band, (...).

    Args:
        errors: at the end of each cycle, m, (..., cycles, 2).
        cycles: N.
        band: m.
    """
    over = np.linalg.norm(errors[..., cycles - 1 :, :], axis=-1) / (0.5 * band) - 2.0 * INSIDE
    found: Array = (np.maximum(over, 0.0) ** 2).sum(axis=-1)
    return found


def trial(shooting: Shooting, openings: Array, cycles: int, band: float, tail: int = TAIL) -> Trial:
    """Return the trial of openings that are free until shortly after N cycles; those that lack are centred.

    Args:
        shooting: the step.
        openings: -1..1, (any number of cycles, joints).
        cycles: N.
        band: m.
        tail: cycles that are looked at after N.
    """
    free = cycles + min(LATE, tail)
    padded = np.zeros((cycles + tail, openings.shape[1]))
    kept = openings[:free]
    padded[: len(kept)] = kept
    return Trial(shooting, padded, shooting.errors(padded[None])[0], free, band)


def least_cycles(found: Trial) -> Trial:
    """Return a trial that settles in the fewest cycles that are found, beginning with one that settles."""
    stride = STRIDE
    while stride > 0:
        fewer = max(found.settled - stride, 1)
        better = reach(trial(found.shooting, found.openings, fewer, found.band), fewer)
        if better is None:
            stride //= 2
        else:
            found = better
    return found


def reach(tried: Trial, cycles: int) -> Trial | None:
    """Return a trial in which the tip stays in its band after so many cycles, None if none is found."""
    weight, left = FIRST_WEIGHT, [tried.excess(cycles)]
    for _ in range(ITERATIONS):
        if tried.settled <= cycles:
            return tried
        better, good = _improved(tried, cycles, weight)
        tried, weight = (tried, weight * HEAVIER) if better is None else (better, good)
        left.append(tried.excess(cycles))
        if weight > LAST_WEIGHT or (len(left) > 2 and left[-1] > STALLED * left[-3]):
            break
    return tried if tried.settled <= cycles else None


def _improved(before: Trial, cycles: int, weight: float) -> tuple[Trial | None, float]:
    """The best of trials with several weights, each corrected for what was not linear, and its weight."""
    weights = (weight * WEIGHTS).tolist()
    runs = np.repeat(before.openings[None], len(weights), axis=0)
    errors = np.repeat(before.errors[None], len(weights), axis=0)
    best, least, good = None, before.excess(cycles), weight
    for _ in range(1 + CORRECTIONS):
        for one, e, lam in zip(runs, errors, weights, strict=True):
            _change(before, one[: before.free], e, cycles, lam)
        errors = before.shooting.errors(runs)
        left = excess(errors, cycles, before.band)
        i = int(np.argmin(left))
        if left[i] < least:
            best = Trial(before.shooting, runs[i].copy(), errors[i], before.free, before.band)
            least, good = float(left[i]), weights[i]
            if best.settled <= cycles:
                break
    return best, good


def _change(before: Trial, openings: Array, errors: Array, cycles: int, weight: float) -> None:
    """Change the free openings, (free, joints), to what is best where errors are linear."""
    rows = np.arange(cycles - 1, len(errors))
    rows = np.concatenate([rows[:DENSE], rows[DENSE::SPARSE]])
    unit, given = 0.5 * before.band, openings.ravel()
    A = before.sensitivities[rows] / unit
    x = least_excess(errors[rows] / unit, A, 2.0 * INSIDE, weight, -1.0 - given, 1.0 - given)
    openings += x.reshape(openings.shape)
    np.clip(openings, -1.0, 1.0, out=openings)
