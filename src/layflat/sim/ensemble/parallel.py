"""Many runs at once: machines, scenarios and seeds that differ from run to run, side by side on all cores.

Memory holds the metrics of all runs, and signals of those that are under way; it does not grow with a run's length.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from layflat.errors import InputError
from layflat.lanes import WIDTH
from layflat.machine import Machine, load
from layflat.machine import units as u
from layflat.sim.ensemble.cases import Cases, cases
from layflat.sim.ensemble.kernel import run_lanes
from layflat.sim.ensemble.watch import DIVERGED, Results, Totals, Traced, new_watch
from layflat.sim.kernel import Timing
from layflat.sim.metrics import BAND
from layflat.sim.run import STEP, timing_of
from layflat.sim.scenario import Scenario, Value
from layflat.sim.tally import COLUMNS

if TYPE_CHECKING:
    import xarray

BLOCK, SHARES = 32, 4
"""Groups of `WIDTH` runs that a thread takes at a time: at most, and so that each thread takes this many times."""

TIP_BAND = 2e-3
"""Within this of its goal the tip has settled, m: section 5 of the paper."""


def ensemble(
    machine: str | Path | Machine,
    scenario: Scenario | Sequence[Scenario] | None = None,
    vary: Mapping[str, ArrayLike] | None = None,
    *,
    runs: int | None = None,
    step: Value = STEP,
    band: Value = BAND,
    tip_band: Value = TIP_BAND,
    traces: Sequence[str] = (),
    every: int = 1,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> xarray.Dataset:
    """Simulate many runs, each with the laws of `rollout`, and measure them.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        scenario: what happens; of several, `vary["scenario"]` tells which happens in which run. All last equally long.
        vary: one number a run (SI) by what it changes: a path of the machine, such as "joint.small.brake.torque";
            "scenario.payload" (kg) and "scenario.supply" (gauge, Pa) where the scenario leaves them as usual;
            "scenario.brake" (factor), "scenario.load" (N m) and "scenario.drift" (V), which come on top, for all joints
            or for one ("scenario.drift.small"); "scenario" (number of the scenario); "seed" (of the noise).
        runs: how many; only needed where nothing varies.
        step: of the plant; rounded so that a control cycle is a whole number of steps.
        band: within this of its goal a joint has settled.
        tip_band: within this of its goal the tip has settled.
        traces: signals to keep, of `Traced`.
        every: control cycles from record to record of the traces.
        threads: how many work at a time; one a core where not given. Results do not depend on it.
        progress: is called with the number of runs each time that some are done.

    Returns:
        Metrics by run (see dataset.py); those of a run that diverged are not numbers.

    Raises:
        InputError: a machine, scenario, path or option is wrong.
    """
    from layflat.sim.ensemble.dataset import measured  # noqa: PLC0415  # xarray takes long to import

    given = [scenario or Scenario()] if scenario is None or isinstance(scenario, Scenario) else list(scenario)
    prepared = cases(load(machine), given, vary or {}, runs)
    bands = u.quantity(band, u.ANGLE, "band"), u.quantity(tip_band, u.LENGTH, "tip_band")
    timing = timing_of(prepared.cycle, u.quantity(step, u.TIME, "step"), 1, closed_loop=True)
    results = _room_for_results(prepared, _columns(traces), every)

    def work(block: NDArray[np.int64]) -> int:
        _run_block(prepared, block, timing, bands, results)
        return min(len(block), prepared.count - int(block[0]))

    workers = threads or os.cpu_count() or 1
    with ThreadPoolExecutor(workers) as pool:
        for done in pool.map(work, _blocks(prepared.count, workers)):
            if progress is not None:
                progress(done)
    return measured(prepared, results, timing.cycle)


def _blocks(count: int, workers: int) -> Iterator[NDArray[np.int64]]:
    """Numbers of the runs of every block; the last run stands in where a group of lanes is not full."""
    size = WIDTH * min(BLOCK, ceil(count / (WIDTH * SHARES * workers)))
    for first in range(0, count, size):
        filled = WIDTH * ceil((min(first + size, count) - first) / WIDTH)
        yield np.minimum(np.arange(first, first + filled), count - 1)


def _columns(traces: Sequence[str]) -> NDArray[np.int64]:
    unknown = sorted(set(traces) - set(Traced._fields))
    if unknown:
        raise InputError(f"{unknown[0]!r} is no signal", where="traces", right=f"use {', '.join(Traced._fields)}")
    return np.array([Traced._fields.index(name) for name in traces], dtype=np.int64)


def _room_for_results(prepared: Cases, columns: NDArray[np.int64], every: int) -> Results:
    if every < 1:
        raise InputError(f"{every} is out of range", where="every", right="give 1 or more")
    n = len(prepared.base.joints)
    records = ceil(prepared.cycles / every) if len(columns) else 0
    return Results(
        np.full((prepared.count, prepared.most_moves, n + 1, COLUMNS), np.nan),
        np.zeros((prepared.count, len(Totals._fields))),
        np.zeros((prepared.count, records, n, len(columns))),
        columns,
        every,
    )


def _run_block(
    prepared: Cases, block: NDArray[np.int64], timing: Timing, bands: tuple[float, float], results: Results
) -> None:
    runs, (plan, moves) = prepared.runs(block), prepared.plan(block, *bands)
    own = results._replace(
        tallies=np.full((len(block), *results.tallies.shape[1:]), np.nan),
        totals=np.zeros((len(block), *results.totals.shape[1:])),
        traces=np.zeros((len(block), *results.traces.shape[1:])),
    )
    own.totals[:, DIVERGED] = np.nan
    for first in range(0, len(block), WIDTH):
        watch = new_watch(WIDTH)
        run_lanes(prepared.template, first, runs, plan, moves, timing, own, watch)
    count = min(len(block), prepared.count - int(block[0]))
    place = slice(int(block[0]), int(block[0]) + count)
    results.tallies[place], results.totals[place] = own.tallies[:count], own.totals[:count]
    results.traces[place] = own.traces[:count]
