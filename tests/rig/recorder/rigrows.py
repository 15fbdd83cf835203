"""Rows that a loop might hand over, and a loop in a process of its own that does."""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from layflat.rig.record import SHARED_COLUMNS, RowLayout
from layflat.rig.recorder.bag import BagWriter, LogHeading
from layflat.rig.recorder.ring import Event, Ring

JOINTS = ("large", "small")
LAW = (("phase", ("1", "phase of the controller")), ("short_term", ("V", "short-term integral F")))
LAYOUT = RowLayout(JOINTS, LAW)
HEADING = LogHeading(LAYOUT, '{"name": "arm"}', "arm", {"driver": "simulated"})
CYCLE = 0.005
BEGIN = 1_700_000_000_000_000_000

LOOP = f"""
import sys, time
from pathlib import Path
import numpy as np
from layflat.rig.recorder.ring import Ring
ring = Ring.attach(Path(sys.argv[1]))
row = np.zeros(ring.head.width)
start, k = time.monotonic(), 0
while True:
    row[:] = k
    row[0], row[1] = k * {CYCLE}, 1.7e9 + k * {CYCLE}
    row[{LAYOUT.shared["fault"]}] = 0.0
    ring.push(row)
    k += 1
    time.sleep(max(0.0, start + k * {CYCLE} - time.monotonic()))
"""


def rows(count: int, seed: int = 0) -> NDArray[np.float64]:
    made = np.random.default_rng(seed).normal(size=(count, LAYOUT.width))
    made[:, 0] = CYCLE * np.arange(count)
    made[:, 1] = 1.7e9 + made[:, 0]
    made[:, LAYOUT.shared["fault"]] = 0.0
    return made


def column(made: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    if name in SHARED_COLUMNS:
        return made[:, LAYOUT.shared[name]]
    first, width = len(SHARED_COLUMNS) + list(LAYOUT.by_joint).index(name), len(LAYOUT.by_joint)
    return made[:, [first + width * joint for joint in range(len(JOINTS))]]


def log_of(path: Path, made: NDArray[np.float64], events: list[Event] | None = None, *, chunked: bool = True) -> Path:
    """A finished log; one record by record is not finished."""
    with path.open("wb") as file:
        bag = BagWriter(file, HEADING, BEGIN, chunked=chunked)
        bag.add(made)
        for event in events or []:
            bag.write_event(event)
        if chunked:
            bag.finish()
    return path


@contextmanager
def running_loop(ring: Ring) -> Iterator[subprocess.Popen[bytes]]:
    """A process that hands over rows at 200 Hz, killed at the end; all numbers of a row are its own, but the times."""
    with subprocess.Popen([sys.executable, "-c", LOOP, str(ring.path)]) as loop:
        try:
            yield loop
        finally:
            loop.kill()


def wait_for(what: Callable[[], bool], within: float = 20.0) -> None:
    until = time.monotonic() + within
    while not what():
        assert time.monotonic() < until, "waited in vain"
        time.sleep(0.005)
