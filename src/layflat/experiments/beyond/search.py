"""Search for the least number of control cycles of a step: valve openings by sequential least squares.

For a number of cycles N the objective is the sum, over all later cycles, of the squared excess of the tip's error over
a little less than the band. Where it reaches zero, the tip settles in N cycles, and fewer are tried. Each iteration is
a bounded least-squares problem of the points outside a disc, solved by a projected Newton method for few rows and many
unknowns.

| symbol | meaning | unit |
|---|---|---|
| x | unknowns | 1 |
| v | points, linear in x: v = v_0 + A x | 1 |
| w | excess of a point: its distance from the origin less the radius, or zero | 1 |
| f | objective: the sum of w^2, and lam x^2 | 1 |
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.kinematics import tip_position
from layflat.motion.scenario import Scenario
from layflat.physics.step import STEP
from layflat.sim.ensemble.parallel import simulate_traces

REST_CYCLES = 4  # control cycles at rest before the step: one period of the dither
OPENING_CHANGE = 0.1  # for a sensitivity by finite difference: large enough to average over stick and slip
DIVERGED_ERROR = 10.0  # error of a run that diverged, m


@dataclass(frozen=True)
class Shooting:
    """Simulation of a step from rest in open loop, with valve openings in place of a controller.

    Args:
        machine: machine whose plant is simulated.
        start: angles at which the arm rests, rad.
        end: angles whose tip is the goal, rad.
        step: step of the plant, s.
    """

    machine: Machine
    start: Sequence[float]
    end: Sequence[float]
    step: float = STEP

    @cached_property
    def goal(self) -> Array:
        """Goal position of the tip, m, (2,)."""
        return tip_position(self.machine, np.array(self.end, dtype=float))

    def errors(self, openings: Array) -> Array:
        """Return the tip's position less its goal at the end of every cycle, m, (runs, cycles, 2).

        Where a run has diverged, both components are `DIVERGED_ERROR`.

        Args:
            openings: -1..1, (runs, cycles, joints).
        """
        runs, cycles, _ = openings.shape
        # Records are of the beginning of a cycle.
        padded = np.pad(openings, ((0, 0), (REST_CYCLES, 1), (0, 0)))
        duration = (REST_CYCLES + cycles + 1) * self.machine.cycle
        scenarios = [Scenario(start=self.start, opening=row, duration=duration, noise=False) for row in padded]
        which = {"scenario": np.arange(runs)}
        angles = simulate_traces(self.machine, scenarios, which, ("angle",), step=self.step)[:, REST_CYCLES + 1 :, :, 0]
        errors: Array = tip_position(self.machine, np.nan_to_num(angles)) - self.goal
        errors[np.isnan(angles).any(axis=2)] = DIVERGED_ERROR
        return errors

    def sensitivities(self, openings: Array, free: int) -> Array:
        """Return the change of the tip's errors with each opening of the first cycles, m, (free, joints, cycles, 2).

        Args:
            openings: -1..1, (cycles, joints).
            free: number of cycles whose openings are varied.
        """
        joints = openings.shape[1]
        changes = np.where(openings[:free] > 0.0, -OPENING_CHANGE, OPENING_CHANGE)
        runs = np.repeat(openings[None], 1 + free * joints, axis=0)
        for i, (k, j) in enumerate(np.ndindex(free, joints)):
            runs[1 + i, k, j] += changes[k, j]
        errors = self.errors(runs)
        changes_of_errors: Array = (errors[1:] - errors[0]).reshape(free, joints, *errors.shape[1:])
        return changes_of_errors / changes[:, :, None, None]


def settling_cycles(errors: Array, band: float) -> Array:
    """Return the number of cycles until the tip stays within a band of its goal, (...); cycles + 1 if it does not.

    Args:
        errors: errors at the end of every cycle, m, (..., cycles, 2).
        band: m.
    """
    outside = np.linalg.norm(errors, axis=-1) > band
    cycles = outside.shape[-1]
    last = cycles - np.argmax(outside[..., ::-1], axis=-1)
    settling: Array = np.where(outside.any(axis=-1), last + 1, 0)
    return settling


DESCENT_STEPS = 30  # upper limit of Newton steps
MIN_DESCENT = 1e-4  # relative decrease of the objective below which the descent ends
STEP_LENGTHS = 0.5 ** np.arange(11)  # that are tried along the Newton direction


def minimize_excess(v_0: Array, A: Array, radius: float, lam: float, low: Array, high: Array) -> Array:
    """Return x, (unknowns,), within bounds, that minimizes the sum of squared excesses and lam x^2.

    Source: projected Newton method of Bertsekas 1982 (key bertsekas1982).

    Args:
        v_0: points where x = 0, (points, 2).
        A: their derivatives by x, (points, 2, unknowns).
        radius: radius of the disc in which a point has no excess.
        lam: weight of x, > 0.
        low: lower bounds of x, (unknowns,), not above zero.
        high: upper bounds of x, (unknowns,), not below zero.
    """
    x, v, before = np.zeros(A.shape[2]), v_0, np.inf
    flat = A.reshape(-1, A.shape[2])
    for _ in range(DESCENT_STEPS):
        slope, rows = _expand_excess(v, A, radius)
        g = slope + lam * x
        free = ~(((x <= low) & (g > 0.0)) | ((x >= high) & (g < 0.0)))
        step = np.where(free, -_solve_damped(rows * free, lam, g * free), 0.0)
        tried = np.clip(x + STEP_LENGTHS[:, None] * step, low, high)
        points = v_0 + (tried @ flat.T).reshape(-1, *v_0.shape)
        excess = np.maximum(np.sqrt((points * points).sum(axis=2)) - radius, 0.0)
        f = (excess * excess).sum(axis=1) + lam * (tried * tried).sum(axis=1)
        i = int(np.argmin(f))
        if before - f[i] < MIN_DESCENT * before:
            break
        x, v, before = tried[i], points[i], f[i]
    return x


def _expand_excess(v: Array, A: Array, radius: float) -> tuple[Array, Array]:
    """Return half the gradient of the squared excesses, and the rows B of half their second derivative B'B."""
    distance = np.maximum(np.linalg.norm(v, axis=1), 1e-12)
    out = distance > radius
    along, A, excess = v[out] / distance[out, None], A[out], distance[out] - radius
    radial = np.einsum("pi,pin->pn", along, A)
    tangential = np.einsum("pi,pin->pn", along[:, ::-1] * (-1.0, 1.0), A) * np.sqrt(excess / distance[out])[:, None]
    return excess @ radial, np.concatenate([radial, tangential])


def _solve_damped(rows: Array, lam: float, g: Array) -> Array:
    """Return (B'B + lam)^-1 g from the rows B, which are fewer than the unknowns (Woodbury)."""
    small = rows @ rows.T + lam * np.eye(len(rows))
    return (g - rows.T @ np.linalg.solve(small, rows @ g)) / lam


AIMED_FRACTION = 0.95  # of the band, beyond which an error has an excess
TAIL_CYCLES = 40  # simulated after N
LATE_CYCLES = 6  # after N with openings that are unknowns; the valves are centred from there on
DENSE_CYCLES, SPARSE_STRIDE = 12, 3  # cycles from N on that all have an error row; of later ones every third has
FIRST_WEIGHT, LAST_WEIGHT = 30.0, 1e6  # lam of squared changes of openings; errors are in halves of the band
WEIGHT_FACTORS = 10.0 ** np.arange(-2, 3)  # of the last successful weight, tried together
WEIGHT_INCREASE = 30.0  # factor of the weight where none of them decreases the excess
MAX_CORRECTIONS = 3  # further steps with the same sensitivities
MAX_ITERATIONS = 14  # with new sensitivities each
STALL_RATIO = 0.8  # of the excess to that two iterations before, above which the search has stalled
FIRST_STRIDE = 4  # cycles by which N is decreased at first


@dataclass(frozen=True)
class OpeningTrial:
    """Valve openings and the simulated errors of the tip.

    Args:
        shooting: the step.
        openings: -1..1, (cycles, joints).
        errors: errors of the tip at the end of each cycle, m, (cycles, 2).
        free: number of first cycles whose openings are unknowns.
        band: distance of the tip from its goal within which it has to stay, m.
    """

    shooting: Shooting
    openings: Array
    errors: Array
    free: int
    band: float

    @cached_property
    def sensitivities(self) -> Array:
        """Derivatives of the errors by the free openings, m, (cycles, 2, free * joints)."""
        changes_of_errors = self.shooting.sensitivities(self.openings, self.free)
        return np.ascontiguousarray(np.moveaxis(changes_of_errors.reshape(-1, *self.errors.shape), 0, -1))

    @property
    def settled(self) -> int:
        """Number of cycles until the tip stays in its band."""
        return int(settling_cycles(self.errors, self.band))

    def excess(self, cycles: int) -> float:
        """Return the sum of squared excesses after so many cycles, in halves of the band."""
        return float(sum_excess(self.errors, cycles, self.band))


def sum_excess(errors: Array, cycles: int, band: float) -> Array:
    """Return the sums of squared excesses after so many cycles, in halves of the band, (...).

    Args:
        errors: errors at the end of each cycle, m, (..., cycles, 2).
        cycles: N.
        band: m.
    """
    over = np.linalg.norm(errors[..., cycles - 1 :, :], axis=-1) / (0.5 * band) - 2.0 * AIMED_FRACTION
    sums: Array = (np.maximum(over, 0.0) ** 2).sum(axis=-1)
    return sums


def simulate_trial(
    shooting: Shooting, openings: Array, cycles: int, band: float, tail: int = TAIL_CYCLES
) -> OpeningTrial:
    """Simulate openings that are free until `LATE_CYCLES` after N cycles; missing and later ones are zero (centred).

    Args:
        shooting: the step.
        openings: -1..1, (any number of cycles, joints).
        cycles: N.
        band: m.
        tail: cycles that are simulated after N.
    """
    free = cycles + min(LATE_CYCLES, tail)
    padded = np.zeros((cycles + tail, openings.shape[1]))
    kept = openings[:free]
    padded[: len(kept)] = kept
    return OpeningTrial(shooting, padded, shooting.errors(padded[None])[0], free, band)


def minimize_cycles(best: OpeningTrial) -> OpeningTrial:
    """Return a trial with as few cycles until it settles as the search reaches, from one that settles."""
    stride = FIRST_STRIDE
    while stride > 0 and best.settled > 1:
        fewer = max(best.settled - stride, 1)
        better = reach_band(simulate_trial(best.shooting, best.openings, fewer, best.band), fewer)
        if better is None:
            stride //= 2
        else:
            best = better
    return best


def reach_band(current: OpeningTrial, cycles: int) -> OpeningTrial | None:
    """Optimize a trial's openings until the tip stays in its band after so many cycles; None if that fails."""
    weight, excesses = FIRST_WEIGHT, [current.excess(cycles)]
    for _ in range(MAX_ITERATIONS):
        if current.settled <= cycles:
            return current
        better, better_weight = _improve_trial(current, cycles, weight)
        current, weight = (current, weight * WEIGHT_INCREASE) if better is None else (better, better_weight)
        excesses.append(current.excess(cycles))
        if weight > LAST_WEIGHT or (len(excesses) > 2 and excesses[-1] > STALL_RATIO * excesses[-3]):
            break
    return current if current.settled <= cycles else None


def _improve_trial(before: OpeningTrial, cycles: int, weight: float) -> tuple[OpeningTrial | None, float]:
    """Return the best trial of several weights, corrected for nonlinearity (None: none is better), and its weight."""
    weights = (weight * WEIGHT_FACTORS).tolist()
    runs = np.repeat(before.openings[None], len(weights), axis=0)
    errors = np.repeat(before.errors[None], len(weights), axis=0)
    best, least_excess, best_weight = None, before.excess(cycles), weight
    for _ in range(1 + MAX_CORRECTIONS):
        for openings, e, lam in zip(runs, errors, weights, strict=True):
            _correct_openings(before, openings[: before.free], e, cycles, lam)
        errors = before.shooting.errors(runs)
        excesses = sum_excess(errors, cycles, before.band)
        i = int(np.argmin(excesses))
        if excesses[i] < least_excess:
            best = OpeningTrial(before.shooting, runs[i].copy(), errors[i], before.free, before.band)
            least_excess, best_weight = float(excesses[i]), weights[i]
            if best.settled <= cycles:
                break
    return best, best_weight


def _correct_openings(before: OpeningTrial, openings: Array, errors: Array, cycles: int, weight: float) -> None:
    """Change the free openings, (free, joints), in place to the least-squares optimum of linearized errors."""
    rows = np.arange(cycles - 1, len(errors))
    rows = np.concatenate([rows[:DENSE_CYCLES], rows[DENSE_CYCLES::SPARSE_STRIDE]])
    unit, current = 0.5 * before.band, openings.ravel()
    A = before.sensitivities[rows] / unit
    x = minimize_excess(errors[rows] / unit, A, 2.0 * AIMED_FRACTION, weight, -1.0 - current, 1.0 - current)
    openings += x.reshape(openings.shape)
    np.clip(openings, -1.0, 1.0, out=openings)
