"""The same cell with many seeds, on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import get_context
from queue import Queue

from layflat.cell.file.model import Cell
from layflat.cell.vision import Calibration
from layflat.cell.work.onlookers import Nobody
from layflat.cell.work.packer import Pick
from layflat.cell.work.run import Run, packed

POLL = 0.2
"""Between two looks at how far the others are, s."""


def repeated(
    cell: Cell, seeds: Sequence[int], picks: int, calibration: Calibration | None,
    progress: Callable[[int], object] = lambda _: None, processes: int | None = None,
) -> Iterator[Run]:  # fmt: skip
    """Runs with all seeds, as they end. Whoever stops iterating stops the work.

    Args:
        cell: its description.
        seeds: each gives one run, the same as alone.
        picks: of each.
        calibration: of the camera; None where there is none.
        progress: is told the picks that have ended so far.
        processes: as many as there are cores where not given.

    Raises:
        LayflatError: as `packed`.
    """
    with _workers(processes or os.cpu_count() or 1) as (pool, told):
        left = {pool.submit(_one, cell, seed, picks, calibration, told) for seed in seeds}
        done = 0
        while left:
            ended, left = wait(left, timeout=POLL)
            while not told.empty():
                done += told.get()
            progress(done)
            for job in ended:
                yield job.result()


@contextmanager
def _workers(processes: int) -> Iterator[tuple[ProcessPoolExecutor, Queue[int]]]:
    context = get_context("spawn")
    with context.Manager() as manager:
        pool = ProcessPoolExecutor(processes, mp_context=context, initializer=_alone)
        try:
            yield pool, manager.Queue()
        finally:
            pool.shutdown(cancel_futures=True)


def _alone() -> None:
    """Each worker draws on one core: there are as many of them as cores."""
    os.environ.setdefault("LP_NUM_THREADS", "1")


class _Teller(Nobody):
    """Tells how many picks have ended."""

    def __init__(self, told: Queue[int]) -> None:
        self._told = told

    def picked(self, pick: Pick) -> None:  # noqa: ARG002  (as all onlookers)
        """One more."""
        self._told.put(1)


def _one(cell: Cell, seed: int, picks: int, calibration: Calibration | None, told: Queue[int]) -> Run:
    return packed(cell, seed, picks, calibration, _Teller(told))
