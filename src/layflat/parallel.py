"""Threads and processes: candidates on all cores, and generators in a subprocess."""

import multiprocessing
import os
import signal
from _thread import interrupt_main
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from importlib import import_module
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from multiprocessing.synchronize import Event
from threading import Thread
from typing import Any, TypeVar

Job = TypeVar("Job")
Submit = Callable[..., Future[Any]]
"""Function that takes a module-level function and its arguments, and returns the future of its result."""

# Signals that a terminal sends to all of its processes.
FROM_TERMINAL = [getattr(signal, name) for name in ("SIGINT", "SIGHUP") if hasattr(signal, name)]


def run_on_all_cores(work: Callable[[Job], None], jobs: Sequence[Job], threads: int | None = None) -> None:
    """Call a function with every job, in threads, and wait for all; a single job runs in this thread.

    The first error, in the order of the jobs, is raised once the running jobs have ended; jobs that have not begun when
    it is noticed are dropped.

    Args:
        work: the function; it stores its results itself.
        jobs: its arguments.
        threads: number of threads, on which results do not depend; default: one a core.
    """
    if len(jobs) == 1:
        work(jobs[0])
        return
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        list(pool.map(work, jobs))


def processors() -> int:
    """Return how many processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux tells
        return os.cpu_count() or 1


def lower_priority() -> None:
    """Leave the processors to all other processes that want them; for good, and only where the system knows it."""
    if hasattr(os, "nice"):
        os.nice(19)


def start_process(
    target: Callable[..., object], arguments: tuple[Any, ...], name: str, *, daemon: bool = False
) -> SpawnProcess:
    """Start a process that Ctrl-C never reaches, not even before its first line.

    Args:
        target: module-level function that it runs.
        arguments: of the function.
        name: of the process.
        daemon: whether it ends with this process.
    """
    process = multiprocessing.get_context("spawn").Process(target=target, args=arguments, name=name, daemon=daemon)
    with _kept_from_terminal():
        process.start()
    return process


def end_process(process: SpawnProcess, timeout: float) -> None:
    """Wait for a process that is ending, and kill it after a timeout, s."""
    process.join(timeout)
    if process.is_alive():
        process.kill()
        process.join()


@contextmanager
def _kept_from_terminal() -> Iterator[None]:
    """Block SIGINT and SIGHUP in processes that start in this block, for good; do nothing on Windows."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # Python starts it with the first process, and then no longer blocks SIGINT
    before = signal.pthread_sigmask(signal.SIG_BLOCK, FROM_TERMINAL)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def process_pool(processes: int | None = None, first: Callable[[], object] | None = None) -> Iterator[Submit]:
    """Yield a function that submits work to processes that Ctrl-C does not reach.

    An error that ends the block, Ctrl-C and the end of a generator included, raises KeyboardInterrupt in running work
    and cancels the rest. Otherwise the end of the block waits for all submitted work.

    Args:
        processes: number of processes; default: one a processor.
        first: called in each process before anything else.
    """
    context = multiprocessing.get_context("spawn")
    ending = context.Event()
    with ProcessPoolExecutor(processes or processors(), context, _initialize_worker, (ending, first)) as pool:

        def submit(work: Callable[..., Any], *arguments: Any) -> Future[Any]:
            with _kept_from_terminal():
                return pool.submit(_run_unless_ending, work, *arguments)

        try:
            yield submit
        except BaseException:
            ending.set()
            pool.shutdown(cancel_futures=True)
            raise


class _Worker:
    """State of a process of a pool: plain values, since a signal's handler can't wait for the lock of an `Event`."""

    is_ending = False  # the whole pool
    at_work = False


def _initialize_worker(ending: Event, first: Callable[[], object] | None) -> None:
    """Initialize a worker process: ignore Ctrl-C, interrupt work at SIGTERM or once `ending` is set; call `first`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _interrupt)
    Thread(target=_interrupt_at_end, args=(ending,), daemon=True).start()
    if first is not None:
        first()


def _interrupt_at_end(ending: Event) -> None:
    """Wait until `ending` is set, and then simulate SIGTERM in the main thread."""
    ending.wait()
    _Worker.is_ending = True
    interrupt_main(signal.SIGTERM)


def _interrupt(*_: object) -> None:
    """Handle SIGTERM in a worker: interrupt its work; without work exit, unless the whole pool is ending."""
    if _Worker.at_work:
        raise KeyboardInterrupt
    if not _Worker.is_ending:
        raise SystemExit(128 + signal.SIGTERM)


def _run_unless_ending(work: Callable[..., Any], *arguments: Any) -> Any:
    """Return the result of work in a worker; raise KeyboardInterrupt if the pool is ending."""
    try:
        _Worker.at_work = True  # before the flag is read: the end of the pool is either read or interrupts
        if _Worker.is_ending:
            raise KeyboardInterrupt
        return work(*arguments)
    finally:
        _Worker.at_work = False


@contextmanager
def generate_in_process(generator: str, *arguments: Any) -> Iterator[Iterator[Any]]:
    """Run a generator in a subprocess, which ends with the block, and yield an iterator over its values as they come.

    The generator is named as "module:function", so that its imports run in the subprocess, concurrently. There are no
    values with one processor or without POSIX, and they end early after an error there: the caller computes the rest.
    """
    if processors() < 2 or os.name != "posix":
        yield iter(())
        return
    ours, theirs = multiprocessing.Pipe(duplex=False)
    process = start_process(_send_values, (generator, arguments, theirs), "layflat aside", daemon=True)
    theirs.close()
    try:
        yield _received_values(ours)
    finally:
        process.kill()
        process.join()
        ours.close()


def _received_values(pipe: Connection) -> Generator[Any]:
    """Yield the values that are received from a pipe until its other end is closed."""
    with suppress(EOFError, OSError):
        while True:
            yield pipe.recv()


def _send_values(generator: str, arguments: tuple[Any, ...], pipe: Connection) -> None:
    """Send a generator's values through a pipe; an error ends them, and occurs again where the rest is computed."""
    module, function = generator.split(":")
    with suppress(Exception):
        for value in getattr(import_module(module), function)(*arguments):
            pipe.send(value)
