"""The same cell with many seeds, on all cores."""

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing import active_children, get_context
from queue import Queue

from layflat.cell.file.model import Cell
from layflat.cell.vision import Calibration
from layflat.cell.work.observer import PickCounter
from layflat.cell.work.run import Run, packed
from layflat.machine import load

POLL = 0.2  # between two checks of how far the others are, s


def repeated(
    cell: Cell, seeds: Sequence[int], picks: int, calibration: Calibration | None,
    progress: Callable[[int], object] = lambda _: None, processes: int | None = None, machines: Sequence[str] = (),
) -> Iterator[Run]:  # fmt: skip
    """Yield runs with all seeds, each the same as alone, as they end; raise as `packed`.

    Whoever stops iterating stops the work, and Ctrl-C does: runs that had not ended are lost. `progress` is called with
    the picks that have ended so far; by default there is one process a core. Where `machines` are named, each seed
    packs with the one at its number.
    """
    with _workers(processes or os.cpu_count() or 1) as (pool, ended):
        # Workers inherit that Ctrl-C is ignored, and so don't die of one before they can heed it.
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            cells = {seed: _with(cell, machines, seed) for seed in seeds}
            left = {pool.submit(_one, cells[seed], seed, picks, calibration, ended) for seed in seeds}
        finally:
            signal.signal(signal.SIGINT, before)
        done = 0
        while left:
            jobs, left = wait(left, timeout=POLL)
            while not ended.empty():
                done += ended.get()
            progress(done)
            for job in jobs:
                yield job.result()


@contextmanager
def _workers(processes: int) -> Iterator[tuple[ProcessPoolExecutor, Queue[int]]]:
    context = get_context("spawn")
    with context.Manager() as manager:
        pool = ProcessPoolExecutor(processes, mp_context=context, initializer=_alone)
        try:
            yield pool, manager.Queue()
        except BaseException:
            # A Ctrl-C in a terminal reaches the workers too, a signal to this process does not.
            for process in active_children():
                if process.pid is not None:
                    with suppress(ProcessLookupError):
                        os.kill(process.pid, signal.SIGINT)
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def _alone() -> None:
    """Let each worker draw on one core, as there are as many of them, and heed Ctrl-C only while it packs."""
    os.environ.setdefault("LP_NUM_THREADS", "1")
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _with(cell: Cell, machines: Sequence[str], seed: int) -> Cell:
    return cell.model_copy(update={"machine": load(machines[seed % len(machines)])}) if machines else cell


def _one(cell: Cell, seed: int, picks: int, calibration: Calibration | None, ended: Queue[int]) -> Run:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return packed(cell, seed, picks, calibration, PickCounter(lambda _: ended.put(1)))
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
