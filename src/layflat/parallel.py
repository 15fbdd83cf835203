"""Candidates are simulated side by side on all cores; other processes do what this one need not wait for."""

import multiprocessing
import os
import signal
from _thread import interrupt_main
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from importlib import import_module
from math import ceil
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from multiprocessing.synchronize import Event
from threading import Thread
from typing import Any, TypeVar

Job = TypeVar("Job")
Submit = Callable[..., Future[Any]]
"""Takes a function of a module and its arguments, and returns the result as one that will come."""

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
    with _kept_from_terminal():
        process.start()
    return process


@contextmanager
def _kept_from_terminal() -> Iterator[None]:
    """Keep a terminal's signals from processes that begin meanwhile, for good, where the system can."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, FROM_TERMINAL)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def process_pool(processes: int | None = None, first: Callable[[], object] | None = None) -> Iterator[Submit]:
    """Yield what submits work to processes that Ctrl-C does not reach: it is for who waits for the results.

    An error that ends the block, Ctrl-C and the end of a generator included, raises KeyboardInterrupt in the work that
    goes on, and what has not begun never does.

    Args:
        processes: how many; default: one a processor.
        first: called in each process before anything else.
    """
    context = multiprocessing.get_context("spawn")
    ending = context.Event()
    with ProcessPoolExecutor(processes or processors(), context, _begin_worker, (ending, first)) as pool:

        def submit(work: Callable[..., Any], *arguments: Any) -> Future[Any]:
            with _kept_from_terminal():
                return pool.submit(_work, work, *arguments)

        try:
            yield submit
        except BaseException:
            ending.set()
            pool.shutdown(cancel_futures=True)
            raise


class _Worker:
    """State of a process of a pool."""

    ending: Event
    at_work = False


def _begin_worker(ending: Event, first: Callable[[], object] | None) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _interrupt)
    _Worker.ending = ending
    Thread(target=_heed, args=(ending,), daemon=True).start()
    if first is not None:
        first()


def _heed(ending: Event) -> None:
    ending.wait()
    interrupt_main(signal.SIGTERM)


def _interrupt(*_: object) -> None:
    if _Worker.at_work:
        raise KeyboardInterrupt
    if not _Worker.ending.is_set():
        raise SystemExit(128 + signal.SIGTERM)


def _work(work: Callable[..., Any], *arguments: Any) -> Any:
    if _Worker.ending.is_set():
        raise KeyboardInterrupt
    _Worker.at_work = True
    try:
        return work(*arguments)
    finally:
        _Worker.at_work = False


@contextmanager
def aside(generator: str, *arguments: Any) -> Iterator[Iterator[Any]]:
    """Make a generator's values in another process, while this one does something else.

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
