"""Many runs at once on a CUDA device: a thread a run, with the loop and the laws that the processor has.

Runs go to the device in chunks: while it works on one, the next is prepared here. Their noise is made there.
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
from layflat.jit.device import device_kernel, on_device
from layflat.lanes import interpreted, mapped
from layflat.sim.ensemble.block import Block, block_of, keep
from layflat.sim.ensemble.cases import Cases
from layflat.sim.ensemble.kernel import run_lanes
from layflat.sim.ensemble.noise import begin, fill_cycle
from layflat.sim.ensemble.results import Results
from layflat.sim.ensemble.seeds import CALM, Seeds, noise_of, streams, ziggurat
from layflat.sim.ensemble.watch import new_watch, some_lanes
from layflat.sim.kernel import Timing

cuda: Any = _cuda

THREADS = 64  # threads of a block on the device: few, since a run takes as many registers as a thread can have
CHUNK = 512 * 2**20  # bytes that a chunk of runs may bring along and leave behind, at most
SHARE = 4  # of the device's free memory a chunk takes this part at most: another is under way, and threads have stacks

run_one, begin_one, fill_one = on_device(run_lanes), on_device(begin), on_device(fill_cycle)


def run_each(case: Any, runs: Any, plan: Any, moves: Any, timing: Any, results: Any, watch: Any) -> None:
    """Put every run, in the thread of its number, through its scenario."""
    i = cuda.grid(1)
    if i < runs.scenario.shape[0]:
        run_one(case, i, runs, plan, moves, timing, results, some_lanes(watch, i, 1))


def fill_each(streams: Any, ziggurat: Any, noise: Any) -> None:
    """Fill in the noise of every run, in the thread of its number."""
    i = cuda.grid(1)
    if i < noise.shape[3]:
        begin_one(streams, i)
        for k in range(noise.shape[0]):
            fill_one(streams, ziggurat, noise, k, i)


@cache
def _kernel(function: Callable[..., None], law: Any, included: tuple[str, ...]) -> Any:
    # What does a law in every thread; laws from outside may be added between two calls.
    del included
    return device_kernel(function, cache_folder(Path(law.py_func.__code__.co_filename)))


def run_on_device(prepared: Cases, timing: Timing, bands: tuple[float, float], results: Results) -> Iterator[int]:
    """Run all runs and fill in their results; yields how many are done each time that some are.

    Raises:
        InputError: not even one run has room there, or the device fails.
    """
    under_way: list[tuple[Results, int]] = []
    with _failing_in_a_line():
        for rows in _chunks(prepared, results):
            block = block_of(prepared, rows, bands, results, _noise_there)
            under_way.append((_launched(prepared, block, timing), int(rows[0])))
            if len(under_way) > 1:
                yield _collected(results, *under_way.pop(0))
        for launched in under_way:
            yield _collected(results, *launched)


@contextmanager
def _failing_in_a_line() -> Iterator[None]:
    try:
        yield
    except cuda.cudadrv.driver.CudaAPIError as error:
        what = f"the CUDA device failed ({error})"
        raise InputError(what, where="device", right='see nvidia-smi, or use "cpu"') from error


@cache
def check_device() -> None:
    """Try the device with a kernel of one line; a device that works is tried once.

    Raises:
        InputError: the packages it needs are missing, there is no device, or its driver is too old for them.
    """
    if config.ENABLE_CUDASIM:
        if not config.DISABLE_JIT:
            raise InputError(
                "the CUDA simulator runs plain Python", where="device", right="set NUMBA_DISABLE_JIT=1 too"
            )
    else:
        extras.require("gpu", where="device")
    try:
        tried = cuda.to_device(np.zeros(1))
        _start(cuda.jit(_try), 1, tried)
        works = tried.copy_to_host()[0] == 1.0
    except Exception as error:  # the compiler's and the driver's have no class in common
        raise _no_device(error) from error
    if not works:
        raise InputError("the CUDA device computes nothing", where="device", right='use "cpu"')


def _no_device(error: Exception) -> InputError:
    """Return what to say of an error: packages that do not fit together are no fault of the device."""
    reason = str(error).strip().partition("\n")[0]
    missing_library = type(error).__module__.startswith("cuda.pathfinder")
    of_packages = isinstance(error, (AttributeError, TypeError, ImportError)) or missing_library
    if not of_packages or isinstance(error, cuda.cudadrv.error.CudaSupportError):
        return InputError(
            f"no CUDA device can be used ({reason})", where="device", right='see nvidia-smi, or use "cpu"'
        )
    there = [
        f"{name} {version(name)}" for name in ("numba-cuda", "numba", "numpy") if find_spec(name.replace("-", "_"))
    ]
    what = f"the packages for CUDA devices are not whole, or do not fit together ({', '.join(there)}: {reason})"
    return InputError(what, where="device", right="install those that do: pip install 'layflat[gpu]'; or use \"cpu\"")


def _try(number: Any) -> None:
    """Write a number; all threads write the same."""
    number[0] = 1.0


def _chunks(prepared: Cases, results: Results) -> Iterator[NDArray[np.int64]]:
    """Numbers of the runs of every chunk."""
    noisy = any(scenario.noise for scenario in prepared.scenarios)
    brought = len(prepared.numbers) + 2 * noisy * prepared.cycles * len(prepared.base.joints)
    left = (results.tallies.size + results.totals.size + results.traces.size) // prepared.count
    each = np.dtype(prepared.number).itemsize * brought + results.tallies.itemsize * left
    free = cuda.current_context().get_memory_info().free / SHARE
    if each > free:
        what = f"a run takes {each / 2**20:.0f} MiB, and only {free / 2**20:.0f} MiB of the CUDA device are left for it"
        raise InputError(what, where="device", right='ask for shorter runs or fewer traces, or use "cpu"')
    fitting = int(min(CHUNK, free) // each)
    size = THREADS * (fitting // THREADS) or max(1, fitting)
    for first in range(0, prepared.count, size):
        yield np.arange(first, min(first + size, prepared.count))


def kernel_arguments(prepared: Cases, block: Block, timing: Timing) -> tuple[Any, ...]:
    """Return what `run_each` takes to run a block."""
    watch = new_watch(block.runs)
    return prepared.template, block.runs, block.plan, block.moves, timing, block.results, watch


def _noise_there(seeds: Seeds, shape: tuple[int, int], number: type[np.floating[Any]]) -> Any:
    """Make noise as `noise_of` does, on the device, where it stays."""
    if interpreted() or (seeds == CALM).all():
        return noise_of(seeds, shape, number)
    noise = cuda.device_array((*shape, 2, len(seeds)), number)
    begun = mapped((streams(seeds), ziggurat()), _moved)
    _start(_kernel(fill_each, fill_cycle, included_sources()), len(seeds), *begun, noise)
    return noise


def _launched(prepared: Cases, block: Block, timing: Timing) -> Results:
    """Set a block of runs going; returns its results on the device."""
    there = mapped(kernel_arguments(prepared, block, timing), _moved)
    _start(_kernel(run_each, run_lanes, included_sources()), len(block.runs.scenario), *there)
    *_, results, _ = there
    return cast(Results, results)


def _start(kernel: Any, count: int, *args: Any) -> None:
    """Start so many threads, and no wait for them."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*Grid size")  # few runs use a device badly: no mistake
        kernel[ceil(count / THREADS), THREADS](*args)


def _moved(leaf: Any) -> Any:
    return cuda.to_device(np.ascontiguousarray(leaf)) if isinstance(leaf, np.ndarray) else leaf


def _collected(results: Results, there: Any, first: int) -> int:
    """Wait for the runs from number `first` on and keep their results; returns how many they are."""
    tallies, totals, traces = (array.copy_to_host() for array in (there.tallies, there.totals, there.traces))
    return keep(results, there._replace(tallies=tallies, totals=totals, traces=traces), first)
