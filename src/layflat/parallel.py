"""Candidates are simulated side by side on all cores."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from math import ceil
from typing import TypeVar

Job = TypeVar("Job")


def on_all_cores(work: Callable[[Job], None], jobs: Sequence[Job], threads: int | None = None) -> None:
    """Call `work` with every job; results do not depend on the number of `threads` (default: one a core)."""
    if len(jobs) == 1:
        work(jobs[0])
        return
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        list(pool.map(work, jobs))


def parts(count: int, cases: int = 1, threads: int | None = None) -> list[slice]:
    """Divide `count` candidates, each simulated in so many cases, into parts that keep all cores busy."""
    size = max(1, ceil(count * cases / (4 * (threads or os.cpu_count() or 1))))
    return [slice(first, first + size) for first in range(0, count, size)]
