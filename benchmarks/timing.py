"""How long work takes."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

ROUNDS = 15


def median_seconds(work: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Median time of some work, s, after a first call that compiles or warms up."""
    work()
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)
