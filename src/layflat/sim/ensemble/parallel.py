"""Many runs at once: machines, scenarios and seeds that differ from run to run, side by side on all cores.

Memory holds the metrics of all runs, and signals of those that are under way; it does not grow with a run's length.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description import units as u
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.lanes import WIDEST, Like, host_width
from layflat.machine import Machine, load
from layflat.memory import check_memory
from layflat.motion.scenario import Scenario, check_scenario
from layflat.motion.signal_values import Value, check_whole, checked_options, read_number
from layflat.physics.step import STEP
from layflat.sim.ensemble.block import block_of, keep, room_for_results
from layflat.sim.ensemble.cases import Cases, cases
from layflat.sim.ensemble.kernel import run_block
from layflat.sim.ensemble.results import DIVERGED, Results, Traced
from layflat.sim.ensemble.watch import new_watch
from layflat.sim.kernel import Timing
from layflat.sim.metrics import BAND
from layflat.sim.run import timing_of
from layflat.sim.tally import Tally

if TYPE_CHECKING:
    import xarray

BLOCK, SHARES = 32, 4
"""Groups of runs side by side that a thread takes at a time: at most, and so that each thread takes this many times."""

FEW, NARROW = 2, 32
"""Arms of more joints go in lanes of so many bytes at most: numbers of a whole register each would not fit beside each
other into the processor's fastest memory."""

PRECISIONS: dict[str, type[np.floating[Any]]] = {"double": np.float64, "single": np.float32}
SCENARIO_NUMBERS, COPIES = 40, 2.0
"""Numbers of each joint and cycle that a scenario is, with intermediate results; copies of results in memory."""

MAX_THREADS = 4096
MAX_EVERY = 2**31  # control cycles from record to record
LONGEST_SINGLE = 60.0  # runs in single precision, s: time itself is kept in it where the dither is begun anew

TIP_BAND = 2e-3  # within this of its goal the tip has settled, m: section 5 of the paper


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of an ensemble: how its runs are simulated and measured.

    Args:
        runs: how many; only needed where nothing varies.
        step: of the plant; rounded so that a control cycle is a whole number of steps.
        band: within this of its goal a joint has settled.
        tip_band: within this of its goal the tip has settled.
        traces: signals to keep, of `Traced`.
        every: control cycles from record to record of the traces.
        controller: the machine that the controllers believe to drive, and whose controller it is, or its name or file;
            paths of `vary` that begin with "controller." then change this one. Default: each run's own machine.
        precision: "double", or "single": of all numbers of a run, which takes half the time; see docs/speed.md.
        device: "cpu", or "cuda" for a graphics processor of NVIDIA, a run a thread there.
        metrics: names of those to keep, see dataset.py; default: all. Whether a run diverged is told in any case.
        threads: how many of the processor work at a time; default: one a core. Results do not depend on it.
        progress: is called with the number of runs each time that some are done.
    """

    runs: int | None = None
    step: Value = STEP
    band: Value = BAND
    tip_band: Value = TIP_BAND
    traces: Sequence[str] = ()
    every: int = 1
    controller: str | Path | Machine | None = None
    precision: str = "double"
    device: str = "cpu"
    metrics: Sequence[str] | None = None
    threads: int | None = None
    progress: Callable[[int], None] | None = None


def ensemble(
    machine: str | Path | Machine,
    scenario: Scenario | Sequence[Scenario] | None = None,
    vary: Mapping[str, Any] | None = None,
    **options: Any,
) -> "xarray.Dataset":
    """Simulate many runs, each with the laws of `rollout`, and measure them.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        scenario: what happens; of several, `vary["scenario"]` tells which happens in which run. All last equally long.
        vary: one number a run (SI), or one text with a unit, by what it changes: a path of the machine, such as
            "joint.small.brake.torque";
            "scenario.payload" (kg) and "scenario.supply" (gauge, Pa) where the scenario leaves them as usual;
            "scenario.brake" (factor), "scenario.load" (N m) and "scenario.drift" (V), which come on top;
            "scenario.lead" (V/rad) and "scenario.pressure_lead" (V/Pa), by which given voltages grow with what is
            missing to the demand, and fall with the differential pressure; "scenario.spring" (N m/rad) and
            "scenario.damper" (N m s/rad), torques towards the demand and its velocity; all of these for all joints or
            for one ("scenario.drift.small"); what runs begin with, "start.angle.small" (rad),
            "start.pressure_a.small" and "start.pressure_b.small" (absolute, Pa); "scenario" (number of the scenario);
            "seed" (of the noise).
        **options: fields of `Options`, for instance `runs=100`, `traces=("angle",)`, `device="cuda"`.

    Returns:
        Metrics by run (see dataset.py); those of a run that diverged are not numbers.

    Raises:
        InputError: a machine, scenario, path or option is wrong, or no such device can be used.
    """
    from layflat.sim.ensemble.dataset import METRICS, measured  # noqa: PLC0415  # xarray takes long to import

    chosen = checked_options(Options, options, "ensemble")
    metrics = METRICS if chosen.metrics is None else _known(chosen.metrics, METRICS, "metric", "metrics")
    number, columns = _number(chosen.precision), _columns(chosen.traces)
    prepared = cases(
        load(machine), _scenarios(scenario), {} if vary is None else _mapping(vary), chosen.runs,
        controller=None if chosen.controller is None else load(chosen.controller), number=number,
    )  # fmt: skip
    if number is np.float32:
        _check_single(prepared)
    bands = _band(chosen.band, u.ANGLE, "band"), _band(chosen.tip_band, u.LENGTH, "tip_band")
    check_whole(chosen.every, "every", 1, MAX_EVERY)
    workers = os.cpu_count() or 1 if chosen.threads is None else check_whole(chosen.threads, "threads", 1, MAX_THREADS)
    if chosen.progress is not None and not callable(chosen.progress):
        raise InputError(f"{shown(chosen.progress)} can't be called", where="progress", right="give a function")
    timing = _timing(prepared, chosen.step)
    check_size(prepared, len(columns), chosen.every, workers)
    results = room_for_results(prepared, columns, chosen.every)
    for done in _runner(chosen.device, workers)(prepared, timing, bands, results):
        if chosen.progress is not None:
            chosen.progress(done)
    return measured(prepared, results, timing, workers, metrics)


def traced(
    machine: Machine,
    scenario: Scenario | Sequence[Scenario],
    vary: Mapping[str, Any],
    traces: Sequence[str],
    *,
    step: Value = STEP,
    threads: int | None = None,
    together: bool = True,
) -> Array:
    """Simulate as `ensemble` does, and return signals of all runs at the beginning of every control cycle.

    Runs that differ in signals, such as their openings, have a scenario each: `vary["scenario"]` says which. Values
    are checked `together` too, unless what no machine can have is to be simulated. Scenarios may hold what logs hold.

    Returns:
        (runs, cycles, joints, signals); not numbers from where a run diverged.

    Raises:
        InputError: as `ensemble`.
    """
    prepared = cases(machine, _scenarios(scenario), vary, None, together=together, plausible=False)
    columns, workers = _columns(traces), threads or os.cpu_count() or 1
    check_size(prepared, len(columns), 1, workers)
    results = room_for_results(prepared, columns, 1)
    for _ in _run_on_threads(workers, prepared, _timing(prepared, step), (BAND, TIP_BAND), results):
        pass
    begun = np.arange(prepared.cycles) > results.totals[:, DIVERGED, None]
    results.traces[begun] = np.nan
    return results.traces


def _scenarios(given: Scenario | Sequence[Scenario] | None) -> list[Scenario]:
    if given is None:
        return [Scenario()]
    if not isinstance(given, (list, tuple)):
        return [check_scenario(given)]
    if not given:
        raise InputError("holds no scenario", where="scenario", right="give one or more")
    return [check_scenario(one) for one in given]


def _mapping(vary: Any) -> Mapping[str, Any]:
    if not isinstance(vary, Mapping):
        right = 'give {"arm.payload": [1.0, 2.0]}'
        raise InputError(f"{shown(vary)} is no table of what varies", where="vary", right=right)
    wrong = next((key for key in vary if not isinstance(key, str)), None)
    if wrong is not None:
        raise InputError(f"{shown(wrong)} is no path", where="vary", right='give paths such as "arm.payload"')
    return vary


def _band(value: Value, quantity: u.Quantity, where: str) -> float:
    band = read_number(value, quantity, where)
    if not 0.0 < band <= quantity.most:
        raise InputError(f"{band:g} {quantity.unit} is out of range", where=where, right="give more than zero")
    return band


def _number(precision: str) -> type[np.floating[Any]]:
    if not isinstance(precision, str) or precision not in PRECISIONS:
        raise InputError(f"{shown(precision)} is not a precision", where="precision", right='use "double" or "single"')
    return PRECISIONS[precision]


def _check_single(prepared: Cases) -> None:
    """Make sure that single precision is enough for these runs."""
    lasting = prepared.cycles * prepared.cycle
    if lasting > LONGEST_SINGLE:
        what = f"single precision is too coarse for runs of {lasting:g} s"
        raise InputError(what, where="precision", right=f'use "double", or runs of {LONGEST_SINGLE:g} s at most')


def check_size(prepared: Cases, columns: int, every: int, workers: int) -> None:
    """Refuse an ensemble that memory can't hold.

    Args:
        prepared: the ensemble; its scenarios are not expanded before they are known to fit.
        columns: signals that are traced.
        every: control cycles from record to record of the traces.
        workers: threads that simulate blocks of runs side by side.

    Raises:
        InputError: with the estimate: it needs more memory than is free.
    """
    n, cycles, count = len(prepared.base.joints), prepared.cycles, prepared.count
    lanes = host_width(np.dtype(prepared.number).itemsize)
    block = (
        workers
        * _block_size(count, workers, lanes)
        * cycles
        * n
        * (2.0 if any(s.noise for s in prepared.scenarios) else 0.0)
    )
    scenarios = len(prepared.scenarios) * cycles * n * SCENARIO_NUMBERS
    traces = COPIES * count * ceil(cycles / every) * n * columns
    lasting = cycles * prepared.cycle

    def right(part: float) -> str:
        fewer = [f"{max(int(part * count), 1)} runs"] * (count > 1) + ["fewer signals of `traces`"] * (columns > 0)
        return f"give {' or '.join([*fewer, f'{0.9 * part * lasting:.2g} s'])} at a time"

    work = f"an ensemble of {count} runs of {lasting:g} s"
    where = "traces" if traces > block + scenarios else "duration"
    check_memory(8.0 * (block + scenarios + traces), work, where, right)
    tallies = 2.0 * count * prepared.most_moves * (n + 1) * len(Tally._fields)
    check_memory(8.0 * (block + scenarios + traces + tallies), work, "runs", right)


def _timing(prepared: Cases, step: Value) -> Timing:
    return timing_of(prepared.cycle, step, 1, prepared.machine)


def check_device(device: str) -> None:
    """Make sure that runs can be made there, before any work is done.

    Raises:
        InputError: it is unknown, or can't be used.
    """
    if not isinstance(device, str):
        raise InputError(f"{shown(device)} is not a device", where="device", right='use "cpu" or "cuda"')
    if device == "cuda":
        from layflat.sim.ensemble.cuda import check_device as tried  # noqa: PLC0415  # a compiler of its own

        tried()
    elif device != "cpu":
        raise InputError(f"{shown(device)} is not a device", where="device", right='use "cpu" or "cuda"')


def _runner(device: str, workers: int) -> Callable[[Cases, Timing, tuple[float, float], Results], Iterator[int]]:
    """Return the function that runs the cases, fills in results, and yields counts of runs that are done."""
    check_device(device)
    if device == "cuda":
        from layflat.sim.ensemble.cuda import run_on_device  # noqa: PLC0415  # a compiler of its own

        return run_on_device
    return partial(_run_on_threads, workers)


def _run_on_threads(
    workers: int, prepared: Cases, timing: Timing, bands: tuple[float, float], results: Results
) -> Iterator[int]:
    like = Like.of(prepared.case, NARROW if len(prepared.case.joints) > FEW else WIDEST)

    def work(rows: NDArray[np.int64]) -> int:
        block = block_of(prepared, rows, bands, results)
        run_block(like, block.runs, block.plan, block.moves, timing, block.results, new_watch(block.runs))
        return keep(results, block.results, int(rows[0]))

    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(work, _blocks(prepared.count, workers, host_width(np.dtype(prepared.number).itemsize)))


def _blocks(count: int, workers: int, lanes: int) -> Iterator[NDArray[np.int64]]:
    """Numbers of the runs of every block; the last run stands in where a group of lanes is not full."""
    size = _block_size(count, workers, lanes)
    for first in range(0, count, size):
        filled = lanes * ceil((min(first + size, count) - first) / lanes)
        yield np.minimum(np.arange(first, first + filled), count - 1)


def _block_size(count: int, workers: int, lanes: int) -> int:
    return lanes * min(BLOCK, ceil(count / (lanes * SHARES * workers)))


def _columns(traces: Sequence[str]) -> NDArray[np.int64]:
    signals = _known(traces, Traced._fields, "signal", "traces")
    return np.array([Traced._fields.index(name) for name in signals], dtype=np.int64)


def _known(names: Sequence[str], there: Sequence[str], what: str, where: str) -> Sequence[str]:
    """Names of what there is."""
    if not isinstance(names, (list, tuple, set, frozenset)) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{shown(names)} is no list of names", where=where, right=f"use {', '.join(there)}")
    unknown = sorted(set(names) - set(there))
    if unknown:
        raise InputError(f"{unknown[0]!r} is not a {what}", where=where, right=f"use {', '.join(there)}")
    return names
