"""A process beside an event loop, for what takes longer than the loop may be held up: 20 ms."""

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar

from layflat.errors import InputError, LayflatError
from layflat.parallel import start_process

Result = TypeVar("Result")
CLOSING = "the pages are being closed"
STARTS_WITHIN = 60.0  # a new process may have to load and compile what it calls, beside its first call's limit, s


@dataclass(eq=False)
class Call:
    """A call that stands in line or goes on."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float  # s
    what: str
    by: object = None
    cancelled: bool = False


class Worker:
    """One process that calls functions, one after the other, each for so long at most.

    It begins with the first call, and anew after one that was cancelled or took too long.
    """

    def __init__(self, name: str, first: Callable[..., object] | None = None, shared: tuple[Any, ...] = ()) -> None:
        """Take what the process is to be.

        Args:
            name: by which it is listed.
            first: function that is called in it before anything else.
            shared: its arguments; memory that processes share can be given to a process only as it begins.
        """
        self._name, self._first = name, (first, shared)
        self._caller = ThreadPoolExecutor(1, name)  # waits for the process, so that calls stand in line
        self._guard = threading.Lock()
        self._calls: set[Call] = set()  # that are waited for
        self._current: Call | None = None
        self._process: SpawnProcess | None = None
        self._pipe: Connection | None = None
        self._ended = False

    def begin(self, function: Callable[..., object], *arguments: Any) -> None:
        """Begin the process by a call whose result nobody needs, such as one that loads what later calls need."""
        self._caller.submit(self._perform, Call(function, arguments, STARTS_WITHIN, "the beginning"))

    async def call(
        self, function: Callable[..., Result], *arguments: Any, limit: float, what: str, by: object = None
    ) -> Result:
        """Call a function of a module over there, and return what it returns.

        Args:
            function: found there by its name, with arguments and a result that can be pickled.
            arguments: of it.
            limit: time that it may take, s.
            what: the work, for the message where it fails, such as "the search for angles".
            by: who asks for it, as for `cancel`.

        Raises:
            LayflatError: what the function raised, or the work took too long, or was cancelled.
        """
        call = Call(function, arguments, limit, what, by)
        self._calls.add(call)
        try:
            found: Result = await asyncio.get_running_loop().run_in_executor(self._caller, self._perform, call)
        except RuntimeError:  # the caller takes nothing any more
            raise LayflatError(CLOSING) from None
        finally:
            self._calls.discard(call)
        return found

    def cancel(self, by: object) -> None:
        """End the calls that somebody asked for: one that goes on along with the process, others where they stand.

        What others asked for is called in a new process. To be called in the event loop.
        """
        with self._guard:
            for call in self._calls:
                call.cancelled |= call.by is by
            if self._current is not None and self._current.cancelled:
                self._kill()

    def forget(self, by: object) -> None:
        """End the calls of somebody that stand in line: whoever asked is gone. One that goes on does so."""
        with self._guard:
            for call in self._calls:
                call.cancelled |= call.by is by and call is not self._current

    def _perform(self, call: Call) -> Any:
        pipe, patience = self._connected(call)
        try:
            pipe.send((call.function, call.arguments))
            if not pipe.poll(call.limit + patience):
                self._kill()
                raise LayflatError(f"{call.what} took longer than {call.limit:g} s and was ended")
            result, error = pipe.recv()
        except (EOFError, OSError):
            self._kill()  # what is left of a process that died by itself
            if self._ended:
                raise LayflatError(CLOSING) from None
            end = "was cancelled" if call.cancelled else "has ended with its process: try again"
            raise LayflatError(f"{call.what} {end}") from None
        finally:
            self._current = None
        if error is not None:
            raise error
        return result

    def _kill(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()

    def end(self) -> None:
        """End the process for good."""
        self._ended = True
        self._caller.shutdown(wait=False, cancel_futures=True)
        with self._guard:
            self._kill()

    def _connected(self, call: Call) -> tuple[Connection, float]:
        """Return the pipe for a call, and how long the process may take to begin, s."""
        with self._guard:
            if self._ended:
                raise LayflatError(CLOSING)
            if call.cancelled:
                raise LayflatError(f"{call.what} was cancelled")
            self._current = call
            if self._process is not None and self._process.is_alive() and self._pipe is not None:
                return self._pipe, 0.0
            if self._pipe is not None:
                self._pipe.close()
            self._pipe, theirs = Pipe()
            self._process = start_process(_serve, (theirs, *self._first), self._name, daemon=True)
            theirs.close()
            return self._pipe, STARTS_WITHIN


def _serve(pipe: Connection, first: Callable[..., object] | None, shared: tuple[Any, ...]) -> None:
    """Call what comes, until the other side is gone: main function of the process."""
    if first is not None:
        first(*shared)
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
