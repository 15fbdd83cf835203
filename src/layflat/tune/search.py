"""The whole population of gains in one ensemble call: CMA-ES (Hansen 2016, key hansen2016).

Every generation meets conditions of its own, so that none can be learnt by heart. What a generation's best costs is
then luck in part; the middle of the search is not, so that it is this which is judged, now and then, by a panel of
conditions that stays the same. The search takes the coarse step, so that more is tried; the panel and whatever is
reported take the default.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.extras import module
from layflat.machine import Machine
from layflat.physics.step import COARSE
from layflat.tune.conditions import Conditions, candidate_costs
from layflat.tune.knobs import GENERATIONS, Knob, Part, from_shares, rounded, to_shares

WIDTH = 0.15  # spread of the first generation, share of each knob's range
ROUGH = {"step": COARSE, "precision": "single"}  # how candidates are simulated: it ranks them as well
PANEL, PANEL_SEED, EVERY = 128, 1_000_000_000, 5
"""Runs of the panel, its seed, and generations from one judgement by it to the next."""


@dataclass(frozen=True)
class Found:
    """The best values so far, in the knobs' units, their cost by the panel, and the generations that it took."""

    values: Array
    cost: float
    generation: int


class Strategy:
    """A CMA-ES over the unit cube, generation by generation about a first middle (hansen2016); it repeats itself."""

    def __init__(self, first: Array, population: int, seed: int, width: float = WIDTH) -> None:
        options = {"seed": seed, "popsize": population, "bounds": [0.0, 1.0], "verbose": -9}
        cma = module("tune", "cma", where="tune")
        self.inner: Any = cma.CMAEvolutionStrategy(np.clip(first, 0.02, 0.98), width, options)

    def ask(self) -> Array:
        """Return the candidates of the next generation, (candidates, dimensions)."""
        self._asked = self.inner.ask()
        return np.array(self._asked)

    def tell(self, costs: Iterable[float]) -> None:
        """Take what each of these candidates costs."""
        self.inner.tell(self._asked, list(costs))

    @property
    def mean(self) -> Array:
        """The middle of the search, inside the cube."""
        return np.asarray(self.inner.boundary_handler.repair(self.inner.mean))


def judge(machine: Machine, knobs: Sequence[Knob], candidates: Array, by: Conditions, **options: Any) -> Array:
    """Cost of every candidate (candidates, knobs), s, as it would be written; options are those of `ensemble`."""
    vary = by.of(len(candidates))
    for knob, values in zip(knobs, rounded(candidates).T, strict=True):
        for path in knob.paths:
            vary[path] = np.repeat(values * knob.si, by.runs)
    return candidate_costs(by.simulate(machine, vary, **options), by, len(candidates))


Meet = Callable[[int, int], Conditions]
"""Yields the conditions of so many runs, from a seed."""


def panel(meet: Meet) -> Conditions:
    """The conditions by which the best is chosen."""
    return meet(PANEL, PANEL_SEED)


def search(
    machine: Machine,
    knobs: Sequence[Knob],
    start: Array,
    parts: Sequence[Part],
    meet: Meet,
    *,
    seed: int = 1,
    progress: Callable[[Found, int, str], None] = lambda *_: None,
) -> Found:
    """Least cost over the knobs' ranges, one part after the other; each goes on from the best of the last.

    Args:
        machine: to be tuned.
        knobs: what may be turned.
        start: where to begin, in the knobs' units.
        parts: what is looked for, in order.
        meet: yields the conditions that candidates are judged by.
        seed: of the search.
        progress: is told the best so far, the generations done, and the part's name, after every generation.

    Raises:
        InputError: the machine can't be simulated, or cma is not installed.
    """
    by, done = panel(meet), 0
    best = Found(rounded(start), float(judge(machine, knobs, start[None], by)[0]), 0)
    progress(best, 0, "")
    for part in parts:
        places, base = list(part.knobs), best.values
        turned = [knobs[place] for place in places]

        def whole(shares: Array, base: Array = base, places: list[int] = places, turned: list[Knob] = turned) -> Array:
            values = np.tile(base, (len(shares), 1))
            values[:, places] = from_shares(turned, shares)
            return values

        strategy = Strategy(to_shares(turned, base[places]), part.population, seed + 1 + done)
        todo = [stage.runs for stage in part.stages for _ in range(stage.generations)]
        for left, runs in zip(reversed(range(len(todo))), todo, strict=True):
            met = meet(runs, seed * GENERATIONS + done)
            asked = strategy.ask()
            strategy.tell(judge(machine, knobs, whole(asked), met, **ROUGH))
            done += 1
            if done % EVERY == 0 or left == 0:
                middle = rounded(whole(strategy.mean[None]))
                cost = float(judge(machine, knobs, middle, by)[0])
                best = Found(middle[0], cost, done) if cost < best.cost else best
            progress(best, done, part.name)
    return best
