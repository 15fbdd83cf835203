"""How long work takes."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

ROUNDS = 15
STEP = 0.25e-3  # of the plant in what is timed by the step, s: figures of earlier versions can be compared


def median_seconds(work: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Median time of some work, s, after a first call that compiles or warms up."""
    work()
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)
