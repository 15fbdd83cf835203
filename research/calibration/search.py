"""Where nothing is short: CMA-ES (key hansen2016) goes down from anywhere, and who lacks least is asked for all claims.

Noise is other noise in every generation, so that luck helps nobody for long, and machines are looked at the more
closely the less they lack. Where a descent ends depends on where it began: some begin, and those go on whose middle
lacks least. The claims have noise of their own; a machine that has all findings with it has them surely if it lacks
little in looks with other noise.
"""

import itertools
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from layflat.arrays import Array
from layflat.tune.search import Strategy
from research.calibration.effort import CLAIMED, ONCE, OWN_NOISE, ROUGH, ROUGHLY_CLAIMED, Effort

POPULATION = 24  # of a generation
ANYWHERE, NEAR = 0.25, 0.02  # spread of the first, share of the ranges; near a machine
FIRST, AT_ONCE = 6000, 200  # places of which a descent begins at the best, and how many are looked at together
BEGIN = 4  # descents that begin together
STUCK, OVER = 0.97, 50  # share of what was lacked on an average of generations that these still lack after as many
LATELY = 10  # generations by which the level is judged, and after which it is told
FAR = 2.0  # times the level above which it does not matter how much a machine lacks
NEARLY = 1.0  # what a machine may lack that may have all findings
ASKED = 2  # of a generation, beside its middle
OTHERS, APART = 12, 7919  # looks with other noise by which a machine is doubted, and seeds between them
DESCENTS, GENERATIONS, NOISES = 256, 10_000, 10_007  # of a search, of a descent, and seeds from one to the next
SURELY = 0.6  # what a machine may lack in these in the mean

HEATS = ((ROUGH, 1.0, 160, 2), (ROUGHLY_CLAIMED, 0.5, 60, 2))
"""How closely machines are looked at one after the other, down to which level, for how many generations at most, and
how many of the descents go on then."""

Parts = Callable[[Array, int, Effort], dict[str, Array]]
"""From shares (machines, unknowns), a seed of the noise and how closely to look to shortfalls by name."""

Lack = Callable[[Array, int, Effort, Array], Array]
"""From the same and each machine's level to all that it lacks, (machines,); above the level a part of it."""


@dataclass(frozen=True)
class Sought:
    """What is sought: shortfalls by name, their sum, and what a machine (unknowns,) is denied when asked for all."""

    parts: Parts
    lack: Lack
    denied: Callable[[Array], str]


@dataclass(frozen=True)
class Best:
    """The best so far: where it lies in the unknowns' ranges, what it lacks with the claims' noise, after how much."""

    shares: Array
    lacks: dict[str, float]
    descent: int
    generation: int
    doubt: float = np.inf  # what it lacks in looks with other noise, in the mean
    denied: str | None = None  # the first claim that disagrees, empty if none does; None: it was not asked

    @property
    def cost(self) -> float:
        """All that it lacks."""
        return sum(self.lacks.values())

    @property
    def agrees(self) -> bool:
        """Whether it has all findings."""
        return self.denied == ""

    def surely(self, doubt: float) -> bool:
        """Whether it has them with other noise as well, but for so much."""
        return self.agrees and self.doubt <= doubt

    def beats(self, other: "Best") -> bool:
        """Whether it is better: it has all findings, or more surely, or lacks less of them."""
        if self.agrees != other.agrees:
            return self.agrees
        return self.doubt < other.doubt if self.agrees else self.cost < other.cost


@dataclass
class Descent:
    """A search from one place."""

    sought: Sought
    strategy: Strategy
    number: int  # of the seed as well
    generation: int = 0
    medians: list[float] = field(default_factory=list)  # what half of each generation lacks or less, looked at as now
    lowest: Sequence[Array] = ()  # of the last generation, or where it began, each (unknowns,)

    @property
    def middle(self) -> Array:
        """Where the search is, (unknowns,)."""
        return self.strategy.mean

    @property
    def level(self) -> float:
        """What half of the machines lack or less."""
        return float(np.mean(self.medians[-LATELY:])) if self.medians else np.inf

    @property
    def stuck(self) -> bool:
        """Whether it comes to no less."""
        before, lately = self.medians[-2 * OVER : -OVER], self.medians[-OVER:]
        return len(before) == OVER and np.mean(lately) > STUCK * np.mean(before)

    def goes_on(self, effort: Effort, least: float = 0.0, most: int = GENERATIONS) -> Iterator["Descent"]:
        """Go on down to a level, for so many generations at most, or until it is stuck; tells so every now and then."""
        self.medians = []
        while len(self.medians) < most and not self.stuck and (len(self.medians) < LATELY or self.level > least):
            machines = self.strategy.ask()
            # Of those that lack far more than most did, it is enough to know that.
            level = np.full(len(machines), FAR * self.level)
            lacked = self.sought.lack(machines, noise(self.number, self.generation), effort, level)
            self.strategy.tell(lacked)
            self.medians.append(float(np.median(lacked)))
            self.lowest = list(machines[np.argsort(lacked, kind="stable")[:ASKED]])
            self.generation += 1
            if len(self.medians) % LATELY == 0:
                yield self


def noise(number: int, generation: int) -> int:
    """Seed of the noise of a descent's generation; descents count from 1."""
    return (number * GENERATIONS + generation) * NOISES


def search(
    sought: Sought, first: Array | None, count: int, *, seed: int, seconds: float, doubt: float = SURELY
) -> Iterator[tuple[Best, float, float]]:
    """Seek a machine that has all findings in a cube of `count` unknowns.

    Yields the best so far, what half of the machines lack at most, and the time left (s), until a machine surely has
    all or the time is over.

    Args:
        sought: what is sought.
        first: shares near which to begin; None: anywhere.
        count: of the unknowns.
        seed: of the search and of the noise: the same machine finds the same.
        seconds: after which it ends.
        doubt: what a machine that agrees may lack in looks with other noise for the search to end.

    Raises:
        MissingExtraError: cma is not installed.
    """
    until, best = time.monotonic() + seconds, None
    for descent, closely in _descents(sought, first, count, seed):
        over = time.monotonic() > until
        if closely or best is None or (over and not best.agrees):
            found = _asked(sought, descent)
            best = found if best is None or found.beats(best) else best
        yield best, descent.level, until - time.monotonic()
        if over or best.surely(doubt):
            return


def _descents(sought: Sought, first: Array | None, count: int, seed: int) -> Iterator[tuple[Descent, bool]]:
    """Descents as they go on, and whether these look closely."""
    numbers = itertools.count(1 + seed * DESCENTS)
    if first is not None:
        number = next(numbers)
        near = Descent(sought, Strategy(first, POPULATION, 1 + number, NEAR), number, lowest=[first])
        yield near, True
        yield from ((near, True) for _ in near.goes_on(ONCE))
    while True:
        begun: Iterable[Descent] = (_begun(sought, count, next(numbers)) for _ in range(BEGIN))
        for effort, least, most, left in HEATS:
            gone = list[Descent]()
            for descent in begun:
                yield from ((descent, False) for _ in descent.goes_on(effort, least, most))
                gone.append(descent)
            begun = sorted(gone, key=lambda one: _doubt(sought, one.middle))[:left]
        for descent in begun:
            yield from ((descent, True) for _ in descent.goes_on(ONCE))


def _begun(sought: Sought, count: int, number: int) -> Descent:
    """A descent from the best of many places anywhere."""
    rng, least, best = np.random.default_rng(number), np.inf, np.empty(0)
    for _ in range(FIRST // AT_ONCE):
        places = rng.random((AT_ONCE, count))
        lacked = sought.lack(places, noise(number, GENERATIONS - 1), ROUGH, np.full(AT_ONCE, least))
        if lacked.min() < least:
            least, best = float(lacked.min()), places[np.argmin(lacked)]
    return Descent(sought, Strategy(best, POPULATION, 1 + number, ANYWHERE), number)


def _asked(sought: Sought, descent: Descent) -> Best:
    """Look closely at some, and ask whether they have all findings where they may; returns the best of them."""
    places = np.vstack([descent.middle, *descent.lowest])
    parts = sought.parts(places, OWN_NOISE, CLAIMED)
    best = None
    for machine, place in enumerate(places):
        lacks = {name: float(part[machine]) for name, part in parts.items()}
        found = Best(place, lacks, descent.number, descent.generation)
        if found.cost <= NEARLY:
            found = replace(found, denied=sought.denied(place))
        if found.agrees:
            found = replace(found, doubt=_doubt(sought, place))
        best = found if best is None or found.beats(best) else best
    assert best is not None
    return best


def _doubt(sought: Sought, place: Array) -> float:
    """What a machine lacks in the mean of looks with noise that decided nothing."""
    looks = [sought.parts(place[None], OWN_NOISE + APART * (1 + number), ONCE) for number in range(OTHERS)]
    return float(np.mean([sum(float(part[0]) for part in parts.values()) for parts in looks]))
