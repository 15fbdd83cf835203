"""A process beside an event loop, for what takes longer than the loop may be held up: 20 ms."""

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar

from layflat.errors import InputError, LayflatError
from layflat.parallel import start_process

Result = TypeVar("Result")
STARTS_WITHIN = 60.0  # a new process may have to load and compile what it calls, beside its first call's limit, s


class Worker:
    """One process that calls functions, one after the other, each for so long at most.

    It begins with the first call, and anew after one that was cancelled or took too long.
    """

    def __init__(self, name: str) -> None:
        """Take the name by which the process is listed."""
        self._name = name
        self._caller = ThreadPoolExecutor(1, name)  # waits for the process, so that calls stand in line
        self._guard = threading.Lock()
        self._process: SpawnProcess | None = None
        self._pipe: Connection | None = None
        self._ended = False

    def begin(self, function: Callable[..., object], *arguments: Any) -> None:
        """Begin the process by a call whose result nobody needs, such as one that loads what later calls need."""
        self._caller.submit(self._call, function, arguments, STARTS_WITHIN, "the beginning")

    async def call(self, function: Callable[..., Result], *arguments: Any, limit: float, what: str) -> Result:
        """Call a function of a module over there, and return what it returns.

        Args:
            function: found there by its name, with arguments and a result that can be pickled.
            arguments: of it.
            limit: time that it may take, s.
            what: the work, for the message where it fails, such as "the search for angles".

        Raises:
            LayflatError: what the function raised, or the work took too long, or was cancelled.
        """
        work = partial(self._call, function, arguments, limit, what)
        try:
            return await asyncio.get_running_loop().run_in_executor(self._caller, work)
        except RuntimeError:  # the caller takes nothing any more
            raise LayflatError("the pages are being closed") from None

    def _call(self, function: Callable[..., Result], arguments: tuple[Any, ...], limit: float, what: str) -> Result:
        pipe, patience = self._connected()
        try:
            pipe.send((function, arguments))
            if not pipe.poll(limit + patience):
                self.cancel()
                raise LayflatError(f"{what} took longer than {limit:g} s and was ended")
            result, error = pipe.recv()
        except (EOFError, OSError):
            self.cancel()  # what is left of a process that died by itself
            raise LayflatError(f"{what} was cancelled") from None
        if error is not None:
            raise error
        found: Result = result
        return found

    def cancel(self) -> None:
        """End the call that goes on, if one does, along with the process."""
        with self._guard:
            process, self._process = self._process, None
        if process is not None:
            process.kill()

    def end(self) -> None:
        """End the process for good."""
        self._ended = True
        self._caller.shutdown(wait=False, cancel_futures=True)
        self.cancel()

    def _connected(self) -> tuple[Connection, float]:
        """Return the pipe, and how long the process may take to begin, s."""
        with self._guard:
            if self._ended:
                raise LayflatError("the pages are being closed")
            if self._process is not None and self._process.is_alive() and self._pipe is not None:
                return self._pipe, 0.0
            if self._pipe is not None:
                self._pipe.close()
            self._pipe, theirs = Pipe()
            self._process = start_process(_serve, (theirs,), self._name, daemon=True)
            theirs.close()
            return self._pipe, STARTS_WITHIN


def _serve(pipe: Connection) -> None:
    """Call what comes, until the other side is gone: main function of the process."""
    with suppress(EOFError, OSError):
        while True:
            function, arguments = pipe.recv()
            pipe.send(_answer(function, arguments))


def _answer(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, LayflatError | None]:
    try:
        return function(*arguments), None
    except InputError as error:  # errors with arguments of their own do not travel between processes by themselves
        return None, InputError(error.what, where=error.where, right=error.right)
    except LayflatError as error:
        return None, LayflatError(str(error))
    except Exception as error:  # a law or a library failed: the person goes on, and knows
        return None, LayflatError(f"{function.__name__} failed ({type(error).__name__}: {error})")
