"""Simulation of many runs on a CUDA device: a thread per run, with the same loop and laws as on the processor.

Runs go to the device in chunks: while it works on one, the host prepares the next. The device makes their noise.
"""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from math import ceil
from pathlib import Path
from typing import Any, cast

import numpy as np
from numba import cuda as _cuda
from numpy.typing import NDArray

from layflat import extras
from layflat.errors import InputError
from layflat.jit import cache_folder
from layflat.jit.cache import included_sources
from layflat.jit.compiler import config
from layflat.jit.device import device_kernel, device_law
from layflat.lanes import mapped
from layflat.registers import interpreted
from layflat.sim.ensemble.block import RunBlock, make_block, store_results
from layflat.sim.ensemble.cases import Cases
from layflat.sim.ensemble.kernel import run_lanes
from layflat.sim.ensemble.noise import fill_cycle, seed_stream
from layflat.sim.ensemble.results import Results
from layflat.sim.ensemble.seeds import NO_SEED, Seeds, make_noise, seed_streams, ziggurat_tables
from layflat.sim.ensemble.watch import new_watch, slice_watch
from layflat.sim.loop import Timing

cuda: Any = _cuda

BLOCK_THREADS = 64  # threads per block of the device: few, since a run takes as many registers as a thread can have
MAX_CHUNK = 512 * 2**20  # inputs and results of a chunk of runs, bytes
MEMORY_PARTS = 4  # free memory of the device over a chunk: another chunk is in progress, and threads have stacks

run_one, begin_one, fill_one = device_law(run_lanes), device_law(seed_stream), device_law(fill_cycle)


def run_each(case: Any, runs: Any, scenarios: Any, moves: Any, timing: Any, results: Any, watch: Any) -> None:
    """Simulate each run in the thread of its number; surplus threads do nothing.

    Args:
        case: parameters of one run, for their order.
        runs: inputs that differ from run to run.
        scenarios: signals over control cycles.
        moves: moves of every scenario.
        timing: time grid of the runs.
        results: results of all runs, which are filled.
        watch: over all runs.
    """
    i = cuda.grid(1)
    if i < runs.scenario.shape[0]:
        run_one(case, i, runs, scenarios, moves, timing, results, slice_watch(watch, i, 1))


def fill_each(streams: Any, ziggurat: Any, noise: Any) -> None:
    """Fill in the noise of each run, in the thread of its number; surplus threads do nothing.

    Args:
        streams: initial generators, (5, runs), which are advanced in place.
        ziggurat: tables of the normal distribution.
        noise: (cycles, joints, sensors, runs), which is filled.
    """
    i = cuda.grid(1)
    if i < noise.shape[3]:
        begin_one(streams, i)
        for k in range(noise.shape[0]):
            fill_one(streams, ziggurat, noise, k, i)


@cache
def _kernel(function: Callable[..., None], law: Any, included: tuple[str, ...]) -> Any:
    """Return a function as a kernel; the file of the law that it applies determines its folder of compiled code.

    There is one for each state of `included`, the users' files of laws, in the process.
    """
    del included
    return device_kernel(function, cache_folder(Path(law.py_func.__code__.co_filename)))


def run_on_device(prepared: Cases, timing: Timing, bands: tuple[float, float], results: Results) -> Iterator[int]:
    """Simulate all runs and fill in their results; yield the number of runs of each chunk that is done.

    Args:
        prepared: the ensemble.
        timing: time grid of the runs.
        bands: bands of settling of a joint (rad) and of the tip (m).
        results: results of all runs, which are filled.

    Raises:
        InputError: the device's memory can't hold a single run, or the device fails.
    """
    pending: list[tuple[Results, int]] = []
    with _translate_device_errors():
        for rows in _chunks(prepared, results):
            block = make_block(prepared, rows, bands, results, _device_noise)
            pending.append((_launch(prepared, block, timing), int(rows[0])))
            if len(pending) > 1:
                yield _collect(results, *pending.pop(0))
        for chunk in pending:
            yield _collect(results, *chunk)


@contextmanager
def _translate_device_errors() -> Iterator[None]:
    """Raise InputError in place of an error of the CUDA device."""
    try:
        yield
    except cuda.cudadrv.driver.CudaAPIError as error:
        what = f"the CUDA device failed ({error})"
        raise InputError(what, where="device", right='see nvidia-smi, or use "cpu"') from error


@cache
def check_device() -> None:
    """Test the CUDA device with a kernel of one line; a device that works is tested once per process.

    Raises:
        InputError: the packages it needs are missing, there is no device, its driver is too old for them, or Numba's
            CUDA simulator is on without NUMBA_DISABLE_JIT.
    """
    if config.ENABLE_CUDASIM:
        if not config.DISABLE_JIT:
            raise InputError(
                "the CUDA simulator runs plain Python", where="device", right="set NUMBA_DISABLE_JIT=1 too"
            )
    else:
        extras.require("gpu", where="device")
    try:
        number = cuda.to_device(np.zeros(1))
        _start_threads(cuda.jit(_write_one), 1, number)
        works = number.copy_to_host()[0] == 1.0
    except Exception as error:  # errors of the compiler and of the driver have no class in common
        raise _explain_device_error(error) from error
    if not works:
        raise InputError("the CUDA device computes nothing", where="device", right='use "cpu"')


def _explain_device_error(error: Exception) -> InputError:
    """Return an error of the device as one line, which tells incompatible packages from a device that fails."""
    reason = str(error).strip().partition("\n")[0]
    missing_library = type(error).__module__.startswith("cuda.pathfinder")
    of_packages = isinstance(error, (AttributeError, TypeError, ImportError)) or missing_library
    if not of_packages or isinstance(error, cuda.cudadrv.error.CudaSupportError):
        return InputError(
            f"no CUDA device can be used ({reason})", where="device", right='see nvidia-smi, or use "cpu"'
        )
    installed = [
        f"{name} {version(name)}" for name in ("numba-cuda", "numba", "numpy") if find_spec(name.replace("-", "_"))
    ]
    what = f"the packages for CUDA devices are incomplete or incompatible ({', '.join(installed)}: {reason})"
    return InputError(what, where="device", right="install them: pip install 'layflat[gpu]'; or use \"cpu\"")


def _write_one(number: Any) -> None:
    """Write 1 into a number; all threads write the same."""
    number[0] = 1.0


def _chunks(prepared: Cases, results: Results) -> Iterator[NDArray[np.int64]]:
    """Yield the numbers of the runs of each chunk, which fits into the device's memory and `MAX_CHUNK`, in order.

    Raises:
        InputError: the memory can't hold a single run.
    """
    noisy = any(scenario.noise for scenario in prepared.scenarios)
    inputs = len(prepared.numbers) + 2 * noisy * prepared.cycles * len(prepared.base.joints)
    outputs = (results.tallies.size + results.totals.size + results.traces.size) // prepared.count
    run_size = np.dtype(prepared.number).itemsize * inputs + results.tallies.itemsize * outputs
    free = cuda.current_context().get_memory_info().free / MEMORY_PARTS
    if run_size > free:
        left = f"only {free / 2**20:.0f} MiB of the CUDA device are left for it"
        what = f"a run takes {run_size / 2**20:.0f} MiB, and {left}"
        raise InputError(what, where="device", right='ask for shorter runs or fewer traces, or use "cpu"')
    fitting = int(min(MAX_CHUNK, free) // run_size)
    size = BLOCK_THREADS * (fitting // BLOCK_THREADS) or max(1, fitting)
    for first in range(0, prepared.count, size):
        yield np.arange(first, min(first + size, prepared.count))


def kernel_arguments(prepared: Cases, block: RunBlock, timing: Timing) -> tuple[Any, ...]:
    """Return the arguments of `run_each` for a block.

    Args:
        prepared: the ensemble.
        block: block of its runs.
        timing: time grid of the runs.
    """
    watch = new_watch(block.runs)
    return prepared.template, block.runs, block.scenarios, block.moves, timing, block.results, watch


def _device_noise(seeds: Seeds, shape: tuple[int, int], number: type[np.floating[Any]]) -> Any:
    """Return noise as `make_noise` does, made and kept on the device; on the host without noise or when simulated.

    `shape` has the numbers of cycles and joints; `number` is the type of the samples.
    """
    if interpreted() or (seeds == NO_SEED).all():
        return make_noise(seeds, shape, number)
    noise = cuda.device_array((*shape, 2, len(seeds)), number)
    generators = mapped((seed_streams(seeds), ziggurat_tables()), _to_device)
    _start_threads(_kernel(fill_each, fill_cycle, included_sources()), len(seeds), *generators, noise)
    return noise


def _launch(prepared: Cases, block: RunBlock, timing: Timing) -> Results:
    """Start the kernel of a block of runs, without a wait for it, and return its results on the device."""
    arguments = mapped(kernel_arguments(prepared, block, timing), _to_device)
    _start_threads(_kernel(run_each, run_lanes, included_sources()), len(block.runs.scenario), *arguments)
    *_, results, _ = arguments
    return cast(Results, results)


def _start_threads(kernel: Any, count: int, *args: Any) -> None:
    """Start at least `count` threads of a kernel, in whole blocks of `BLOCK_THREADS`, without a wait for them.

    The kernel has to bear the surplus threads: by its check of the thread's number, or as all write the same.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*Grid size")  # a small ensemble uses a device poorly: no mistake
        kernel[ceil(count / BLOCK_THREADS), BLOCK_THREADS](*args)


def _to_device(leaf: Any) -> Any:
    return cuda.to_device(np.ascontiguousarray(leaf)) if isinstance(leaf, np.ndarray) else leaf


def _collect(results: Results, chunk: Any, first: int) -> int:
    """Wait for the runs from number `first` on, copy their results from the device, and return their number."""
    tallies, totals, traces = (array.copy_to_host() for array in (chunk.tallies, chunk.totals, chunk.traces))
    return store_results(results, chunk._replace(tallies=tallies, totals=totals, traces=traces), first)
