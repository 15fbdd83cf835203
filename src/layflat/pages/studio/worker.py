"""One process that simulates, so that pages never wait: of each tab only the newest design is simulated to its end."""

import asyncio
import signal
import threading
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from itertools import count
from multiprocessing import get_context
from multiprocessing.sharedctypes import SynchronizedArray
from typing import Any

from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.pages.server.worker import Worker as Beside
from layflat.pages.studio.cloud import Cloud, OvertakenError, Step, Tolerances, cloud

TABS = 256  # that are told apart; more share a number, and may overtake each other

_wanted: dict[str, Any] = {}
"""In the process that simulates: the number of the newest request of each tab."""


class Worker:
    """Simulates in another process, which is begun with the first request and again if it ends."""

    def __init__(self) -> None:
        self.beside = Beside("layflat-studio")  # for what takes less than a cloud, and must not wait for one
        self._context = get_context("spawn")
        self._newest: SynchronizedArray[int] = self._context.Array("Q", TABS)
        self._pool: ProcessPoolExecutor | None = None
        self._ended = False
        self._tabs = count()
        self._lock = threading.Lock()

    def tab(self) -> int:
        """Return a number for a tab."""
        return next(self._tabs) % TABS

    def begin(self) -> None:
        """Begin the process, so that it is ready when it is needed."""
        self._submit(_nothing)

    def overtake(self, tab: int, number: int) -> None:
        """Let requests of a tab that are older than a number end without a result."""
        self._newest[tab] = number

    async def cloud(
        self, tab: int, number: int, machine: Machine, step: Step, tolerances: Tolerances
    ) -> Cloud | LayflatError | None:
        """Return the cloud of a machine; the error that it ends with; or None where it was overtaken.

        Args:
            tab: whose request it is.
            number: of the request; the tab's numbers grow.
            machine: that is simulated.
            step: what it does.
            tolerances: how far runs differ.
        """
        self.overtake(tab, number)
        for _ in range(2):
            try:
                return await asyncio.wrap_future(self._submit(_cloud, tab, number, machine, step, tolerances))
            except BrokenProcessPool:  # somebody has ended the process: another one begins
                self.close()
        return LayflatError("the process that simulates has ended; change a value to begin again")

    def end(self) -> None:
        """End the process for good."""
        self._ended = True
        self.beside.end()
        self.close()

    def close(self) -> None:
        """End the process; another one begins with the next request."""
        with self._lock:
            pool, self._pool = self._pool, None
        if pool is not None:
            processes = list((pool._processes or {}).values())
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()

    def _submit(self, work: Any, *arguments: Any) -> "Future[Any]":
        with self._lock:
            if self._ended:
                raise BrokenProcessPool
            if self._pool is None:
                self._pool = ProcessPoolExecutor(1, self._context, _begin, (self._newest,))
            return self._pool.submit(work, *arguments)


def _begin(newest: "SynchronizedArray[int]") -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that serves
    _wanted["newest"] = newest


def _nothing() -> None:
    pass


def _cloud(tab: int, number: int, machine: Machine, step: Step, tolerances: Tolerances) -> Cloud | LayflatError | None:
    def overtaken() -> bool:
        return bool(_wanted["newest"][tab] > number)

    if overtaken():
        return None
    try:
        return cloud(machine, step, tolerances, overtaken=overtaken).rank()
    except OvertakenError:
        return None
    except LayflatError as error:
        return LayflatError(str(error))  # errors with arguments of their own do not travel between processes
