"""Blocks of runs: the arguments of the compiled loop, and the arrays of its results."""

from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.sim.ensemble.cases import Cases
from layflat.sim.ensemble.results import DIVERGENCE_CYCLE, MoveArrays, Results, Runs, ScenarioArrays, Totals
from layflat.sim.ensemble.seeds import NoiseSource, make_noise
from layflat.sim.tally import COLUMNS


class RunBlock(NamedTuple):
    """Runs that one call of the compiled loop simulates."""

    runs: Runs
    scenarios: ScenarioArrays
    moves: MoveArrays
    results: Results


def allocate_results(prepared: Cases, columns: NDArray[np.int64], every: int) -> Results:
    """Return arrays for the results of all runs: tallies NaN, the rest 0.

    Args:
        prepared: the ensemble.
        columns: columns of `Traced` to keep; empty for no traces.
        every: control cycles from one record of a trace to the next.
    """
    n = len(prepared.base.joints)
    records = ceil(prepared.cycles / every) if len(columns) else 0
    return Results(
        np.full((prepared.count, prepared.max_moves, n + 1, COLUMNS), np.nan),
        np.zeros((prepared.count, len(Totals._fields))),
        np.zeros((prepared.count, records, n, len(columns))),
        columns,
        every,
    )


def make_block(
    prepared: Cases,
    rows: NDArray[np.int64],
    bands: tuple[float, float],
    results: Results,
    make: NoiseSource = make_noise,
) -> RunBlock:
    """Return some runs with the arrays of their results.

    Args:
        prepared: the ensemble.
        rows: numbers of the runs, (runs,).
        bands: bands of settling of a joint (rad) and of the tip (m).
        results: results of all runs, whose shapes and columns the block's results take.
        make: source of the sensors' noise.
    """
    count = len(rows)
    block_results = results._replace(
        tallies=np.full((count, *results.tallies.shape[1:]), np.nan),
        totals=np.zeros((count, *results.totals.shape[1:])),
        traces=np.zeros((count, *results.traces.shape[1:])),
    )
    block_results.totals[:, DIVERGENCE_CYCLE] = np.nan
    return RunBlock(prepared.runs(rows, make), *prepared.scenario_arrays(rows, *bands), block_results)


def store_results(results: Results, block: Results, first: int) -> int:
    """Copy the results of a block into those of all runs, and return the number of runs copied.

    Args:
        results: results of all runs.
        block: results of the block; runs beyond the last one of `results` are padding and left out.
        first: number of the block's first run.
    """
    rows = slice(first, first + len(block.totals))
    count = len(results.totals[rows])
    for whole, part in zip(results[:3], block[:3], strict=True):
        whole[rows] = part[:count]
    return count
