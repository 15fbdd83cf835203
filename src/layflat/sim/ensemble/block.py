"""A block of runs: the arguments of the compiled loop, and where its results go."""

from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.sim.ensemble.cases import Cases
from layflat.sim.ensemble.results import DIVERGED, Moves, Plan, Results, Runs, Totals
from layflat.sim.ensemble.seeds import Make, noise_of
from layflat.sim.tally import COLUMNS


class Block(NamedTuple):
    """Runs that are done together."""

    runs: Runs
    plan: Plan
    moves: Moves
    results: Results


def room_for_results(prepared: Cases, columns: NDArray[np.int64], every: int) -> Results:
    """Results of all runs, before they ran."""
    n = len(prepared.base.joints)
    records = ceil(prepared.cycles / every) if len(columns) else 0
    return Results(
        np.full((prepared.count, prepared.most_moves, n + 1, COLUMNS), np.nan),
        np.zeros((prepared.count, len(Totals._fields))),
        np.zeros((prepared.count, records, n, len(columns))),
        columns,
        every,
    )


def block_of(
    prepared: Cases, rows: NDArray[np.int64], bands: tuple[float, float], results: Results, make: Make = noise_of
) -> Block:
    """The runs numbered `rows` (see `Cases.runs`), with results of their own, shaped like those of all runs."""
    count = len(rows)
    own = results._replace(
        tallies=np.full((count, *results.tallies.shape[1:]), np.nan),
        totals=np.zeros((count, *results.totals.shape[1:])),
        traces=np.zeros((count, *results.traces.shape[1:])),
    )
    own.totals[:, DIVERGED] = np.nan
    return Block(prepared.runs(rows, make), *prepared.plan(rows, *bands), own)


def keep(results: Results, own: Results, first: int) -> int:
    """Put the results of a block into those of all runs, from number `first` on; returns how many there were."""
    place = slice(first, first + len(own.totals))
    count = len(results.totals[place])
    for whole, part in ((results.tallies, own.tallies), (results.totals, own.totals), (results.traces, own.traces)):
        whole[place] = part[:count]
    return count
