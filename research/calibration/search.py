"""Search for a machine without shortfalls: CMA-ES (key hansen2016) from random points, then a check of all claims.

Every generation has other noise, so that no machine is selected by chance for long, and the evaluation gets more
accurate as the shortfall falls. The result of a descent depends on its beginning: several are begun, and those with
the least shortfall at their mean continue. The claims have a noise of their own; a machine that meets all findings
with it is accepted if its mean shortfall with other noise is small.
"""

import itertools
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from layflat.arrays import Array
from layflat.tune.search import Strategy
from research.calibration.effort import (
    CLAIM_EFFORT,
    OWN_NOISE,
    ROUGH_CLAIM_EFFORT,
    ROUGH_EFFORT,
    SINGLE_EFFORT,
    EvaluationEffort,
)

POPULATION = 24  # of a generation
INITIAL_DEVIATION, NEAR_DEVIATION = 0.25, 0.02  # fractions of the ranges; the latter near a known machine
INITIAL_SAMPLES, BATCH_SIZE = 6000, 200  # points, at the best of which a descent begins; evaluated together
DESCENT_COUNT = 4  # that begin together
STALL_RATIO, STALL_GENERATIONS = 0.97, 50  # ratio of mean shortfalls of consecutive spans, and length of a span
LEVEL_GENERATIONS = 10  # over which the level is averaged, and after which it is reported
LEVEL_FACTOR = 2.0  # times the level, beyond which a shortfall is not evaluated fully
CLAIM_CHECK_LEVEL = 1.0  # shortfall up to which all claims are evaluated
CHECKED_MACHINES = 2  # of a generation, besides its mean
NOISE_CHECKS, SEED_STRIDE = 12, 7919  # evaluations of an accepted machine with other noise, and seeds between them
MAX_DESCENTS, MAX_GENERATIONS = 256, 10_000  # of a search, and of a descent
NOISE_STRIDE = 10_007  # seeds from one generation to the next
MAX_RESIDUAL = 0.6  # mean shortfall with other noise up to which a machine is accepted

SELECTION_STAGES = ((ROUGH_EFFORT, 1.0, 160, 2), (ROUGH_CLAIM_EFFORT, 0.5, 60, 2))
"""Stages of a descent: effort, level at which the stage ends, limit of generations, and descents that continue."""

Parts = Callable[[Array, int, EvaluationEffort], dict[str, Array]]
"""Function from shares (machines, unknowns), seed of the noise and effort to shortfalls by name."""

Lack = Callable[[Array, int, EvaluationEffort, Array], Array]
"""Function from the same and each machine's level to total shortfalls, (machines,); partial above the level."""


@dataclass(frozen=True)
class SearchTarget:
    """Target of a search: shortfalls by name, their sum, and the first claim that a machine (unknowns,) fails."""

    parts: Parts
    lack: Lack
    denied: Callable[[Array], str]


@dataclass(frozen=True)
class BestMachine:
    """Best machine so far: its position in the unknowns' ranges, and its shortfalls with the claims' noise."""

    shares: Array
    lacks: dict[str, float]
    descent: int
    generation: int
    doubt: float = np.inf  # what it lacks in looks with other noise, in the mean
    denied: str | None = None  # the first claim that disagrees, empty if none does; None: it was not asked

    @property
    def cost(self) -> float:
        """Sum of its shortfalls."""
        return sum(self.lacks.values())

    @property
    def agrees(self) -> bool:
        """True if all claims agree."""
        return self.denied == ""

    def surely(self, doubt: float) -> bool:
        """Return whether all claims agree, and the mean shortfall with other noise is within a limit."""
        return self.agrees and self.doubt <= doubt

    def beats(self, other: "BestMachine") -> bool:
        """Return whether it is better than another: by its claims, then by its shortfalls."""
        if self.agrees != other.agrees:
            return self.agrees
        return self.doubt < other.doubt if self.agrees else self.cost < other.cost


@dataclass
class Descent:
    """Descent of CMA-ES from one point."""

    sought: SearchTarget
    strategy: Strategy
    number: int  # of the seed as well
    generation: int = 0
    medians: list[float] = field(default_factory=list)  # what half of each generation lacks or less, looked at as now
    lowest: Sequence[Array] = ()  # of the last generation, or where it began, each (unknowns,)

    @property
    def middle(self) -> Array:
        """Mean of the search's distribution, (unknowns,)."""
        return self.strategy.mean

    @property
    def level(self) -> float:
        """Median shortfall, averaged over the last generations."""
        return float(np.mean(self.medians[-LEVEL_GENERATIONS:])) if self.medians else np.inf

    @property
    def stuck(self) -> bool:
        """True if the shortfall has stopped falling."""
        before, lately = self.medians[-2 * STALL_GENERATIONS : -STALL_GENERATIONS], self.medians[-STALL_GENERATIONS:]
        return len(before) == STALL_GENERATIONS and np.mean(lately) > STALL_RATIO * np.mean(before)

    def goes_on(self, effort: EvaluationEffort, least: float = 0.0, most: int = MAX_GENERATIONS) -> Iterator["Descent"]:
        """Continue down to a level, a limit of generations, or a stall; yield itself every `LEVEL_GENERATIONS`."""
        self.medians = []
        while (
            len(self.medians) < most
            and not self.stuck
            and (len(self.medians) < LEVEL_GENERATIONS or self.level > least)
        ):
            machines = self.strategy.ask()
            # Shortfalls far beyond the level need not be exact.
            level = np.full(len(machines), LEVEL_FACTOR * self.level)
            lacked = self.sought.lack(machines, noise_seed(self.number, self.generation), effort, level)
            self.strategy.tell(lacked)
            self.medians.append(float(np.median(lacked)))
            self.lowest = list(machines[np.argsort(lacked, kind="stable")[:CHECKED_MACHINES]])
            self.generation += 1
            if len(self.medians) % LEVEL_GENERATIONS == 0:
                yield self


def noise_seed(number: int, generation: int) -> int:
    """Return the seed of the noise of a descent's generation; descents count from 1."""
    return (number * MAX_GENERATIONS + generation) * NOISE_STRIDE


def search(
    sought: SearchTarget, first: Array | None, count: int, *, seed: int, seconds: float, doubt: float = MAX_RESIDUAL
) -> Iterator[tuple[BestMachine, float, float]]:
    """Search for a machine that meets all findings in a unit cube of `count` unknowns.

    Yield the best machine so far, the level of the descent, and the time left (s), until a machine is accepted or the
    time is over.

    Args:
        sought: target of the search.
        first: shares near which to begin; None: random ones.
        count: of the unknowns.
        seed: of the search and of the noise; the result is reproducible.
        seconds: after which it ends.
        doubt: mean shortfall with other noise up to which a machine is accepted.

    Raises:
        MissingExtraError: cma is not installed.
    """
    until, best = time.monotonic() + seconds, None
    for descent, closely in _descents(sought, first, count, seed):
        over = time.monotonic() > until
        if closely or best is None or (over and not best.agrees):
            found = _check_claims(sought, descent)
            best = found if best is None or found.beats(best) else best
        yield best, descent.level, until - time.monotonic()
        if over or best.surely(doubt):
            return


def _descents(sought: SearchTarget, first: Array | None, count: int, seed: int) -> Iterator[tuple[Descent, bool]]:
    """Yield descents as they continue, and whether these are of the last, accurate stage."""
    numbers = itertools.count(1 + seed * MAX_DESCENTS)
    if first is not None:
        number = next(numbers)
        near = Descent(sought, Strategy(first, POPULATION, 1 + number, NEAR_DEVIATION), number, lowest=[first])
        yield near, True
        yield from ((near, True) for _ in near.goes_on(SINGLE_EFFORT))
    while True:
        begun: Iterable[Descent] = (_start_descent(sought, count, next(numbers)) for _ in range(DESCENT_COUNT))
        for effort, least, most, left in SELECTION_STAGES:
            gone = list[Descent]()
            for descent in begun:
                yield from ((descent, False) for _ in descent.goes_on(effort, least, most))
                gone.append(descent)
            begun = sorted(gone, key=lambda one: _mean_shortfall(sought, one.middle))[:left]
        for descent in begun:
            yield from ((descent, True) for _ in descent.goes_on(SINGLE_EFFORT))


def _start_descent(sought: SearchTarget, count: int, number: int) -> Descent:
    """Return a descent from the best of many random points."""
    rng, least, best = np.random.default_rng(number), np.inf, np.empty(0)
    for _ in range(INITIAL_SAMPLES // BATCH_SIZE):
        places = rng.random((BATCH_SIZE, count))
        lacked = sought.lack(places, noise_seed(number, MAX_GENERATIONS - 1), ROUGH_EFFORT, np.full(BATCH_SIZE, least))
        if lacked.min() < least:
            least, best = float(lacked.min()), places[np.argmin(lacked)]
    return Descent(sought, Strategy(best, POPULATION, 1 + number, INITIAL_DEVIATION), number)


def _check_claims(sought: SearchTarget, descent: Descent) -> BestMachine:
    """Evaluate some machines of a descent accurately, with all claims where those may agree; return the best."""
    places = np.vstack([descent.middle, *descent.lowest])
    parts = sought.parts(places, OWN_NOISE, CLAIM_EFFORT)
    best = None
    for machine, place in enumerate(places):
        lacks = {name: float(part[machine]) for name, part in parts.items()}
        found = BestMachine(place, lacks, descent.number, descent.generation)
        if found.cost <= CLAIM_CHECK_LEVEL:
            found = replace(found, denied=sought.denied(place))
        if found.agrees:
            found = replace(found, doubt=_mean_shortfall(sought, place))
        best = found if best is None or found.beats(best) else best
    assert best is not None
    return best


def _mean_shortfall(sought: SearchTarget, place: Array) -> float:
    """Return the mean shortfall of a machine with noise that was not used in the search."""
    looks = [
        sought.parts(place[None], OWN_NOISE + SEED_STRIDE * (1 + number), SINGLE_EFFORT)
        for number in range(NOISE_CHECKS)
    ]
    return float(np.mean([sum(float(part[0]) for part in parts.values()) for parts in looks]))
