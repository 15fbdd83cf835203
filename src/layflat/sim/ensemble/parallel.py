"""Simulation of many runs at once on all cores: machines, scenarios and seeds that vary from run to run.

Memory holds the metrics of all runs, and signals of the runs in progress; it does not grow with a run's duration.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
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
from layflat.lanes import Like
from layflat.machine import Machine, load
from layflat.memory import check_memory
from layflat.motion.scenario import Scenario, check_scenario
from layflat.motion.signal_values import Value, check_integer, read_number
from layflat.physics.step import STEP
from layflat.registers import MAX_REGISTER_BYTES, host_width
from layflat.sim.ensemble.block import allocate_results, make_block, store_results
from layflat.sim.ensemble.cases import Cases, prepare_cases
from layflat.sim.ensemble.kernel import run_block
from layflat.sim.ensemble.results import DIVERGENCE_CYCLE, Results, Traced
from layflat.sim.ensemble.watch import new_watch
from layflat.sim.loop import Timing
from layflat.sim.metrics import SETTLING_BAND, TIP_BAND
from layflat.sim.run import make_timing
from layflat.sim.tally import Tally

if TYPE_CHECKING:
    from layflat.sim.results import Metrics

MAX_GROUPS, BLOCKS_PER_THREAD = 32, 4
"""Size of a block of runs: max groups of lanes in it, and blocks that every thread should get."""

MAX_WIDE_JOINTS, NARROW_BYTES = 2, 32
"""Arms of more joints use SIMD lanes of at most so many bytes, since wider numbers would not fit into the L1 cache."""

NUMBER_TYPES: dict[str, type[np.floating[Any]]] = {"double": np.float64, "single": np.float32}
SCENARIO_NUMBERS, RESULT_COPIES = 40, 2.0
"""Numbers that a scenario takes per joint and cycle, with intermediate results; copies of the results in memory."""

MAX_THREADS = 4096
MAX_EVERY = 2**31  # control cycles from record to record
MAX_SINGLE_DURATION = 60.0  # of runs in single precision, s: time, from which the dither's phase follows, is single too


def ensemble(
    machine: str | Path | Machine,
    scenario: Scenario | Sequence[Scenario] | None = None,
    vary: Mapping[str, Any] | None = None,
    *,
    runs: int | None = None,
    step: Value = STEP,
    band: Value = SETTLING_BAND,
    tip_band: Value = TIP_BAND,
    traces: Sequence[str] = (),
    every: int = 1,
    controller: str | Path | Machine | None = None,
    precision: str = "double",
    device: str = "cpu",
    metrics: Sequence[str] | None = None,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> "Metrics":
    """Simulate many runs, each with the laws of `rollout`, and return their metrics.

    Keys of `vary` are paths of the machine, such as "joint.small.brake.torque", and
    "scenario.payload" (kg) and "scenario.supply" (gauge, Pa), where the scenario does not set them;
    "scenario.brake" (a factor of the scenario's), "scenario.load" (N m) and "scenario.drift" (V), which are added to
    the scenario's;
    "scenario.lead" (V/rad) and "scenario.pressure_lead" (V/Pa), gains that add to a set voltage the error of the angle
    and subtract the differential pressure; "scenario.spring" (N m/rad) and "scenario.damper" (N m s/rad), gains of a
    torque towards the demand and its velocity; all of these for all joints or for one ("scenario.drift.small");
    the state at the start, "start.angle.small" (rad), "start.pressure_a.small" and "start.pressure_b.small" (absolute,
    Pa); "scenario" (number of the scenario); "seed" (of the noise).

    Args:
        machine: a description, its file, or the name of a built-in machine.
        scenario: signals and disturbances; of several scenarios, all with the same duration, `vary["scenario"]` holds
            the number of each run's.
        vary: one number (SI) or text with a unit per run, by the key that it changes.
        runs: number of runs; only needed if nothing varies.
        step: time step of the plant; rounded so that a control cycle is a whole number of steps; a number is in s.
        band: settling band of a joint; a number is in rad.
        tip_band: settling band of the tip; a number is in m.
        traces: names of the signals to keep over time, of `Traced`.
        every: control cycles from one record of the traces to the next.
        controller: the machine whose controller drives, with that machine's parameters as its model, or its name or
            file; keys of `vary` that begin with "controller." then change this one. Default: each run's own machine.
        precision: "double" or "single", of all numbers of a run; single takes half the time; see docs/speed.md.
        device: "cpu", or "cuda" for an NVIDIA graphics processor, with a thread per run.
        metrics: names of the metrics to keep, see results.py; default: all. "diverged" is always kept.
        threads: number of threads; default: one per core. Results do not depend on it.
        progress: called with the number of runs that are newly done, whenever some are.

    Returns:
        Metrics by run (see results.py); those of a run that diverged are NaN.

    Raises:
        InputError: a machine, scenario, path or argument is wrong, or no such device can be used.

    Example:
        >>> import layflat as lf
        >>> step = lf.Scenario(demand={"large": "20 deg"}, start="0 deg", duration="1.5 s")
        >>> runs = lf.ensemble("paper-arm", step, {"arm.payload": [0.5, 1.5, 2.5]}, metrics=("settling",))
        >>> runs["settling"].max(("move", "joint")).values.round(2)
        array([0.94, 1.  , 1.26])
        >>> figure = runs.plot()
    """
    from layflat.sim.ensemble.dataset import metrics_dataset  # noqa: PLC0415  # xarray takes long to import
    from layflat.sim.results import METRICS  # noqa: PLC0415

    kept = METRICS if metrics is None else _check_names(metrics, METRICS, "metric", "metrics")
    number, columns = number_type(precision), _columns(traces)
    prepared = prepare_cases(
        load(machine), _check_scenarios(scenario), {} if vary is None else check_vary(vary), runs,
        controller=None if controller is None else load(controller), number=number,
    )  # fmt: skip
    if number is np.float32:
        _check_single(prepared)
    bands = _read_band(band, u.ANGLE, "band"), _read_band(tip_band, u.LENGTH, "tip_band")
    check_integer(every, "every", 1, MAX_EVERY)
    workers = os.cpu_count() or 1 if threads is None else check_integer(threads, "threads", 1, MAX_THREADS)
    if progress is not None and not callable(progress):
        raise InputError(f"{shown(progress)} can't be called", where="progress", right="give a function")
    timing = _timing(prepared, step)
    check_size(prepared, len(columns), every, workers)
    results = allocate_results(prepared, columns, every)
    for done in _runner(device, workers)(prepared, timing, bands, results):
        if progress is not None:
            progress(done)
    return metrics_dataset(prepared, results, timing, workers, kept)


def simulate_traces(
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

    Signals of the scenarios are not checked to be plausible for the machine, so that logs can be replayed.

    Args:
        machine: the machine.
        scenario: one, or several: `vary["scenario"]` holds the number of each run's.
        vary: values, one per run, by the key that they change; see `ensemble`.
        traces: names of the signals, of `Traced`.
        step: time step of the plant; a number is in s.
        threads: number of threads; default: one per core.
        together: whether the machines that result are also checked as a whole.

    Returns:
        Signals, (runs, cycles, joints, signals); NaN from where a run diverged.

    Raises:
        InputError: as `ensemble`.
    """
    prepared = prepare_cases(machine, _check_scenarios(scenario), vary, None, together=together, plausible=False)
    columns, workers = _columns(traces), threads or os.cpu_count() or 1
    check_size(prepared, len(columns), 1, workers)
    results = allocate_results(prepared, columns, 1)
    for _ in _run_on_threads(workers, prepared, _timing(prepared, step), (SETTLING_BAND, TIP_BAND), results):
        pass
    after_divergence = np.arange(prepared.cycles) > results.totals[:, DIVERGENCE_CYCLE, None]
    results.traces[after_divergence] = np.nan
    return results.traces


def lane_bytes(joints: int) -> int:
    """Return the maximum size in bytes of the lanes of an arm of so many joints."""
    return NARROW_BYTES if joints > MAX_WIDE_JOINTS else MAX_REGISTER_BYTES


def _check_scenarios(scenarios: Scenario | Sequence[Scenario] | None) -> list[Scenario]:
    """Return the scenarios as a list, one that does nothing by default; raise InputError unless each is a scenario."""
    if scenarios is None:
        return [Scenario()]
    if not isinstance(scenarios, (list, tuple)):
        return [check_scenario(scenarios)]
    if not scenarios:
        raise InputError("holds no scenario", where="scenario", right="give one or more")
    return [check_scenario(scenario) for scenario in scenarios]


def check_vary(vary: Any) -> Mapping[str, Any]:
    """Return the table of what varies.

    Raises:
        InputError: it is no mapping, or a key in it is no text.
    """
    if not isinstance(vary, Mapping):
        right = 'give {"arm.payload": [1.0, 2.0]}'
        raise InputError(f"{shown(vary)} is no table of what varies", where="vary", right=right)
    bad_key = next((key for key in vary if not isinstance(key, str)), None)
    if bad_key is not None:
        raise InputError(f"{shown(bad_key)} is no path", where="vary", right='give paths such as "arm.payload"')
    return vary


def _read_band(value: Value, quantity: u.Quantity, where: str) -> float:
    """Return a settling band in SI units; raise InputError unless it is positive and in the range of its quantity."""
    band = read_number(value, quantity, where)
    if not 0.0 < band <= quantity.most:
        right = f"give more than zero, up to {quantity.most:g} {quantity.unit}"
        raise InputError(f"{band:g} {quantity.unit} is out of range", where=where, right=right)
    return band


def number_type(precision: str) -> type[np.floating[Any]]:
    """Return the type of numbers of a precision, "double" or "single".

    Raises:
        InputError: there is no such precision.
    """
    if not isinstance(precision, str) or precision not in NUMBER_TYPES:
        raise InputError(f"{shown(precision)} is not a precision", where="precision", right='use "double" or "single"')
    return NUMBER_TYPES[precision]


def _check_single(prepared: Cases) -> None:
    """Raise InputError if single precision is too coarse for runs of this duration."""
    duration = prepared.cycles * prepared.cycle
    if duration > MAX_SINGLE_DURATION:
        what = f"single precision is too coarse for runs of {duration:g} s"
        raise InputError(what, where="precision", right=f'use "double", or runs of {MAX_SINGLE_DURATION:g} s at most')


def check_size(prepared: Cases, columns: int, every: int, workers: int) -> None:
    """Check that memory can hold an ensemble, before its scenarios are expanded.

    Args:
        prepared: the ensemble.
        columns: number of signals that are traced.
        every: control cycles from one record of the traces to the next.
        workers: threads that simulate blocks of runs in parallel.

    Raises:
        InputError: it needs more memory than is free; with the estimate.
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
    traces = RESULT_COPIES * count * ceil(cycles / every) * n * columns
    duration = cycles * prepared.cycle

    def right(part: float) -> str:
        fewer = [f"{max(int(part * count), 1)} runs"] * (count > 1) + ["fewer signals of `traces`"] * (columns > 0)
        return f"give {' or '.join([*fewer, f'{0.9 * part * duration:.2g} s'])} at a time"

    work = f"an ensemble of {count} runs of {duration:g} s"
    where = "traces" if traces > block + scenarios else "duration"
    check_memory(8.0 * (block + scenarios + traces), work, where, right)
    tallies = 2.0 * count * prepared.max_moves * (n + 1) * len(Tally._fields)
    check_memory(8.0 * (block + scenarios + traces + tallies), work, "runs", right)


def _timing(prepared: Cases, step: Value) -> Timing:
    return make_timing(prepared.cycle, step, 1, prepared.machine)


def check_device(device: str) -> None:
    """Check that a device, "cpu" or "cuda", can simulate runs.

    Raises:
        InputError: it is unknown, or can't be used.
    """
    if not isinstance(device, str):
        raise InputError(f"{shown(device)} is not a device", where="device", right='use "cpu" or "cuda"')
    if device == "cuda":
        from layflat.sim.ensemble.cuda import check_device as check_cuda  # noqa: PLC0415  # loads another compiler

        check_cuda()
    elif device != "cpu":
        raise InputError(f"{shown(device)} is not a device", where="device", right='use "cpu" or "cuda"')


def _runner(device: str, workers: int) -> Callable[[Cases, Timing, tuple[float, float], Results], Iterator[int]]:
    """Return the function that simulates the ensemble, fills in the results, and yields numbers of runs done."""
    check_device(device)
    if device == "cuda":
        from layflat.sim.ensemble.cuda import run_on_device  # noqa: PLC0415  # loads another compiler

        return run_on_device
    return partial(_run_on_threads, workers)


def _run_on_threads(
    workers: int, prepared: Cases, timing: Timing, bands: tuple[float, float], results: Results
) -> Iterator[int]:
    """Simulate all runs in blocks on threads, fill in `results`, and yield the number of runs of each block."""
    like = Like.from_tuple(prepared.case, lane_bytes(len(prepared.case.joints)))

    def work(rows: NDArray[np.int64]) -> int:
        """Simulate runs, store their results, and return their number."""
        block = make_block(prepared, rows, bands, results)
        run_block(like, block.runs, block.scenarios, block.moves, timing, block.results, new_watch(block.runs))
        return store_results(results, block.results, int(rows[0]))

    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(work, _blocks(prepared.count, workers, host_width(np.dtype(prepared.number).itemsize)))


def _blocks(count: int, workers: int, lanes: int) -> Iterator[NDArray[np.int64]]:
    """Yield the numbers of the runs of every block; the last run is repeated to fill a group of lanes."""
    size = _block_size(count, workers, lanes)
    for first in range(0, count, size):
        filled = lanes * ceil((min(first + size, count) - first) / lanes)
        yield np.minimum(np.arange(first, first + filled), count - 1)


def _block_size(count: int, workers: int, lanes: int) -> int:
    return lanes * min(MAX_GROUPS, ceil(count / (lanes * BLOCKS_PER_THREAD * workers)))


def _columns(traces: Sequence[str]) -> NDArray[np.int64]:
    """Return the column numbers in `Traced` of these signals; raise InputError if one is unknown."""
    signals = _check_names(traces, Traced._fields, "signal", "traces")
    return np.array([Traced._fields.index(name) for name in signals], dtype=np.int64)


def _check_names(names: Sequence[str], choices: Sequence[str], what: str, where: str) -> Sequence[str]:
    """Return names that are all among the choices; raise InputError for any other, where `what` is their noun."""
    if not isinstance(names, (list, tuple, set, frozenset)) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{shown(names)} is no list of names", where=where, right=f"use {', '.join(choices)}")
    unknown = sorted(set(names) - set(choices))
    if unknown:
        raise InputError(f"{unknown[0]!r} is not a {what}", where=where, right=f"use {', '.join(choices)}")
    return names
