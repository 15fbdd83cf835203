"""Search by CMA-ES (hansen2016), with the whole population of a generation in one ensemble.

Every generation has conditions of its own, so that the search does not overfit. The cost of a generation's best is then
partly chance; therefore the mean of the search is judged, every few generations, by a constant panel of conditions. The
search uses the coarse time step, for more candidates; the panel and all reported results use the default.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.extras import import_extra
from layflat.machine import Machine
from layflat.physics.step import COARSE_STEP
from layflat.tune.conditions import Conditions, candidate_costs
from layflat.tune.knobs import MAX_GENERATIONS, Knob, SearchPart, fractions_to_values, round_values, values_to_fractions

INITIAL_DEVIATION = 0.15  # spread of the first generation, share of each knob's range
SEARCH_OPTIONS = {"step": COARSE_STEP, "precision": "single"}  # of candidates: they rank as with the defaults
PANEL_RUNS, PANEL_SEED, PANEL_INTERVAL = 128, 1_000_000_000, 5
"""Runs of the panel, its seed, and generations between judgements by it."""


@dataclass(frozen=True)
class SearchResult:
    """Best values of a search so far."""

    values: Array  # in the knobs' units, (knobs,)
    cost: float  # by the panel, s
    generation: int  # after which they were reached


class Strategy:
    """Deterministic CMA-ES over the unit cube, generation by generation, from an initial mean (hansen2016)."""

    def __init__(self, first: Array, population: int, seed: int, width: float = INITIAL_DEVIATION) -> None:
        options = {"seed": seed, "popsize": population, "bounds": [0.0, 1.0], "verbose": -9}
        cma = import_extra("tune", "cma", where="tune")
        self.inner: Any = cma.CMAEvolutionStrategy(np.clip(first, 0.02, 0.98), width, options)

    def ask(self) -> Array:
        """Return the candidates of the next generation, (candidates, dimensions)."""
        self._asked = self.inner.ask()
        return np.array(self._asked)

    def tell(self, costs: Iterable[float]) -> None:
        """Update the search with the costs of these candidates."""
        self.inner.tell(self._asked, list(costs))

    @property
    def mean(self) -> Array:
        """Mean of the search, inside the cube."""
        return np.asarray(self.inner.boundary_handler.repair(self.inner.mean))


def evaluate_costs(machine: Machine, knobs: Sequence[Knob], candidates: Array, by: Conditions, **options: Any) -> Array:
    """Return the cost of every candidate, with values rounded as they are written.

    Args:
        machine: machine to be tuned.
        knobs: varied values.
        candidates: values in the knobs' units, (candidates, knobs).
        by: conditions.
        options: options of `ensemble`.

    Returns:
        Costs, s, (candidates,).
    """
    vary = by.repeat_varied(len(candidates))
    for knob, values in zip(knobs, round_values(candidates).T, strict=True):
        for path in knob.paths:
            vary[path] = np.repeat(values * knob.si, by.runs)
    return candidate_costs(by.simulate(machine, vary, **options), by, len(candidates))


MakeConditions = Callable[[int, int], Conditions]
"""Function from a number of runs (a power of two) and a seed to conditions."""


def panel_conditions(make_conditions: MakeConditions) -> Conditions:
    """Return the conditions by which the best values are selected."""
    return make_conditions(PANEL_RUNS, PANEL_SEED)


def search_knob_values(
    machine: Machine,
    knobs: Sequence[Knob],
    start: Array,
    parts: Sequence[SearchPart],
    make_conditions: MakeConditions,
    *,
    seed: int = 1,
    progress: Callable[[SearchResult, int, str], None] = lambda *_: None,
) -> SearchResult:
    """Return the values of minimum cost in the knobs' ranges, part by part, each from the best of the one before.

    Args:
        machine: machine to be tuned.
        knobs: varied values.
        start: first values in the knobs' units, (knobs,).
        parts: parts of the search, in order.
        make_conditions: function to the conditions of candidates.
        seed: seed of the search.
        progress: called after every generation with the best so far, the generations done, and the part's name.

    Raises:
        InputError: the machine can't be simulated, or cma is not installed.
    """
    by, done = panel_conditions(make_conditions), 0
    best = SearchResult(round_values(start), float(evaluate_costs(machine, knobs, start[None], by)[0]), 0)
    progress(best, 0, "")
    for part in parts:
        places, base = list(part.knobs), best.values
        turned = [knobs[place] for place in places]

        def whole(shares: Array, base: Array = base, places: list[int] = places, turned: list[Knob] = turned) -> Array:
            """Return the values of all knobs, the varied ones at fractions of their ranges, the others at `base`."""
            values = np.tile(base, (len(shares), 1))
            values[:, places] = fractions_to_values(turned, shares)
            return values

        strategy = Strategy(values_to_fractions(turned, base[places]), part.population, seed + 1 + done)
        todo = [stage.runs for stage in part.stages for _ in range(stage.generations)]
        for remaining, runs in zip(reversed(range(len(todo))), todo, strict=True):
            conditions = make_conditions(runs, seed * MAX_GENERATIONS + done)
            candidates = strategy.ask()
            strategy.tell(evaluate_costs(machine, knobs, whole(candidates), conditions, **SEARCH_OPTIONS))
            done += 1
            if done % PANEL_INTERVAL == 0 or remaining == 0:
                middle = round_values(whole(strategy.mean[None]))
                cost = float(evaluate_costs(machine, knobs, middle, by)[0])
                best = SearchResult(middle[0], cost, done) if cost < best.cost else best
            progress(best, done, part.name)
    return best
