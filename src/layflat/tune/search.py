"""The whole population of gains in one ensemble call: CMA-ES (Hansen 2016, key hansen2016)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine
from layflat.sim.ensemble import ensemble
from layflat.tune.conditions import Conditions
from layflat.tune.cost import candidate_costs
from layflat.tune.knobs import Knob

Array = NDArray[np.float64]

POPULATION = 20
WIDTH = 0.2
"""Spread of the first generation, share of each knob's range."""


@dataclass(frozen=True)
class Found:
    """The best values so far, in the knobs' units, their cost, and the number of generations."""

    values: Array
    cost: float
    generations: int


def judge(machine: Machine, knobs: Sequence[Knob], candidates: Array, by: Conditions) -> Array:
    """Cost of every candidate (candidates, knobs), s."""
    # As they will be written: so that what is found is what stands in the file.
    written = np.array([[float(f"{value:.3g}") for value in row] for row in candidates])
    vary = by.of(len(candidates))
    for knob, values in zip(knobs, written.T, strict=True):
        for path in knob.paths:
            vary[path] = np.repeat(values * knob.si, by.runs)
    return candidate_costs(ensemble(machine, by.scenarios, vary), by.window, len(candidates))


def search(
    machine: Machine,
    knobs: Sequence[Knob],
    start: Array,
    stages: Sequence[tuple[int, Conditions]],
    *,
    seed: int = 1,
    progress: Callable[[Found], bool] | None = None,
) -> Found:
    """Least cost over the knobs' ranges.

    Args:
        machine: to be tuned.
        knobs: what may be turned.
        start: where to begin, in the knobs' units.
        stages: numbers of generations and what they are judged by: a few conditions first, all of them later.
        seed: of the search.
        progress: is told the best so far after every generation; the search ends when it returns False.

    Raises:
        InputError: the machine can't be simulated.
    """
    import cma  # noqa: PLC0415  # needed to tune only

    low, high = np.array([k.low for k in knobs]), np.array([k.high for k in knobs])
    options = {"seed": seed, "popsize": POPULATION, "bounds": [0.0, 1.0], "verbose": -9}
    strategy: Any = cma.CMAEvolutionStrategy(np.clip((start - low) / (high - low), 0.02, 0.98), WIDTH, options)  # type: ignore[attr-defined]
    generation, best = 0, Found(start, np.inf, 0)
    for number, (generations, by) in enumerate(stages):
        if number > 0 or not np.isfinite(best.cost):
            best = Found(best.values, float(judge(machine, knobs, best.values[None], by)[0]), generation)
        for _ in range(generations):
            asked = strategy.ask()
            candidates = low + np.array(asked) * (high - low)
            costs = judge(machine, knobs, candidates, by)
            strategy.tell(asked, list(costs))
            generation += 1
            if costs.min() < best.cost:
                best = Found(candidates[costs.argmin()], float(costs.min()), generation)
            if progress is not None and not progress(best):
                return best
    return best
