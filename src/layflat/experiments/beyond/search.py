"""The least number of control cycles after which a tip can stay at its goal: openings by sequential least squares.

For a number of cycles N what is least is the sum over all later cycles of the squared excess of the tip's error over
a little less than the band. Where that can be brought to nothing N is reached, and a smaller one is tried. Each step is
a bounded least-squares problem of what lies outside a disc, solved by a projected Newton method for few rows and many
unknowns.

| symbol | meaning | unit |
|---|---|---|
| x | unknowns | 1 |
| v | points, linear in x: v = v_0 + A x | 1 |
| w | excess of a point: its distance from the origin less the radius, or zero | 1 |
| f | what is least: the sum of w^2, and lam x^2 | 1 |
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from layflat.arrays import Array
from layflat.experiments.beyond.shooting import Shooting, settled

DESCENT_STEPS = 30
ENOUGH = 1e-4  # an iteration that gains a smaller share is the last
LENGTHS = 0.5 ** np.arange(11)  # of steps along the Newton direction, of which the best is taken


def least_excess(v_0: Array, A: Array, radius: float, lam: float, low: Array, high: Array) -> Array:
    """Return x, (unknowns,), within bounds, such that the sum of squared excesses and lam x^2 is least.

    Source: projected Newton method of Bertsekas 1982 (key bertsekas1982).

    Args:
        v_0: points where x = 0, (points, 2).
        A: their change with x, (points, 2, unknowns).
        radius: of the disc in which a point has no excess.
        lam: weight of x, > 0.
        low: bounds of x, (unknowns,), not above zero.
        high: likewise, not below zero.
    """
    x, v, before = np.zeros(A.shape[2]), v_0, np.inf
    flat = A.reshape(-1, A.shape[2])
    for _ in range(DESCENT_STEPS):
        slope, rows = _expanded(v, A, radius)
        g = slope + lam * x
        free = ~(((x <= low) & (g > 0.0)) | ((x >= high) & (g < 0.0)))
        step = np.where(free, -_solved(rows * free, lam, g * free), 0.0)
        tried = np.clip(x + LENGTHS[:, None] * step, low, high)
        points = v_0 + (tried @ flat.T).reshape(-1, *v_0.shape)
        excess = np.maximum(np.sqrt((points * points).sum(axis=2)) - radius, 0.0)
        f = (excess * excess).sum(axis=1) + lam * (tried * tried).sum(axis=1)
        i = int(np.argmin(f))
        if before - f[i] < ENOUGH * before:
            break
        x, v, before = tried[i], points[i], f[i]
    return x


def _expanded(v: Array, A: Array, radius: float) -> tuple[Array, Array]:
    """Half the gradient of the squared excesses, and the rows B of half their second derivative B'B."""
    distance = np.maximum(np.linalg.norm(v, axis=1), 1e-12)
    out = distance > radius
    along, A, excess = v[out] / distance[out, None], A[out], distance[out] - radius
    radial = np.einsum("pi,pin->pn", along, A)
    tangential = np.einsum("pi,pin->pn", along[:, ::-1] * (-1.0, 1.0), A) * np.sqrt(excess / distance[out])[:, None]
    return excess @ radial, np.concatenate([radial, tangential])


def _solved(rows: Array, lam: float, g: Array) -> Array:
    """(B'B + lam)^-1 g by way of the rows, which are fewer than the unknowns."""
    small = rows @ rows.T + lam * np.eye(len(rows))
    return (g - rows.T @ np.linalg.solve(small, rows @ g)) / lam


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
