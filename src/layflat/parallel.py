"""Candidates are simulated side by side on all cores; other processes do what this one need not wait for."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from importlib import import_module
from math import ceil
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar

Job = TypeVar("Job")

# Signals that a terminal sends to all of its processes.
FROM_TERMINAL = [getattr(signal, name) for name in ("SIGINT", "SIGHUP") if hasattr(signal, name)]


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


def processors() -> int:
    """Return how many processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux tells
        return os.cpu_count() or 1


def start_process(
    target: Callable[..., object], arguments: tuple[Any, ...], name: str, *, daemon: bool = False
) -> SpawnProcess:
    """Start a process that Ctrl-C never reaches, not even before its first line: its host decides what that means."""
    process = multiprocessing.get_context("spawn").Process(target=target, args=arguments, name=name, daemon=daemon)
    before = signal.pthread_sigmask(signal.SIG_BLOCK, FROM_TERMINAL)
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return process


@contextmanager
def aside(generator: str, *arguments: Any) -> Iterator[Iterator[Any]]:
    """Let another process make a generator's values, while this one does something else.

    The generator is named as "module:function", so that what it imports is imported there, at the same time. Yields
    the values as they come. They end early where there is but one processor or no POSIX, or something went wrong over
    there: whoever needs the rest has to make it.
    """
    if processors() < 2 or os.name != "posix":
        yield iter(())
        return
    ours, theirs = multiprocessing.Pipe(duplex=False)
    process = start_process(_make, (generator, arguments, theirs), "layflat aside", daemon=True)
    theirs.close()
    try:
        yield _received(ours)
    finally:
        process.kill()
        process.join()
        ours.close()


def _received(pipe: Connection) -> Generator[Any]:
    with suppress(EOFError, OSError):
        while True:
            yield pipe.recv()


def _make(generator: str, arguments: tuple[Any, ...], pipe: Connection) -> None:
    """Main function of the process; an error there is found again, and told, by whoever makes the rest."""
    module, function = generator.split(":")
    with suppress(Exception):
        for value in getattr(import_module(module), function)(*arguments):
            pipe.send(value)
