"""The same cell with many seeds, on all cores."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import wait
from multiprocessing import get_context
from queue import Queue

from layflat.cell.file.model import Cell
from layflat.cell.vision import Calibration
from layflat.cell.work.observer import PickCounter
from layflat.cell.work.run import Run, packed
from layflat.machine import load
from layflat.parallel import process_pool

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
    with (
        get_context("spawn").Manager() as manager,
        process_pool(processes or os.cpu_count(), _draw_on_one_core) as submit,
    ):
        ended, done = manager.Queue(), 0
        left = {submit(_one, _with(cell, machines, seed), seed, picks, calibration, ended) for seed in seeds}
        while left:
            jobs, left = wait(left, timeout=POLL)
            while not ended.empty():
                done += ended.get()
            progress(done)
            for job in jobs:
                yield job.result()


def _draw_on_one_core() -> None:
    os.environ.setdefault("LP_NUM_THREADS", "1")  # there are as many processes as cores


def _with(cell: Cell, machines: Sequence[str], seed: int) -> Cell:
    return cell.model_copy(update={"machine": load(machines[seed % len(machines)])}) if machines else cell


def _one(cell: Cell, seed: int, picks: int, calibration: Calibration | None, ended: Queue[int]) -> Run:
    return packed(cell, seed, picks, calibration, PickCounter(lambda _: ended.put(1)))
