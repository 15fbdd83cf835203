"""Worker process of an event loop, for calls that take longer than the loop may be held up: 20 ms."""

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
CLOSING_TEXT = "the pages are being closed"
START_TIMEOUT = 60.0  # for a new process to load and compile, on top of its first call's limit, s


@dataclass(eq=False)
class WorkerCall:
    """Call of a function that waits or runs."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float  # s
    what: str
    by: object = None
    cancelled: bool = False


class ProcessWorker:
    """Process that calls functions one after the other, each within a time limit.

    It starts with the first call, and restarts after a call that was cancelled or took too long.
    """

    def __init__(self, name: str, first: Callable[..., object] | None = None, shared: tuple[Any, ...] = ()) -> None:
        """Prepare the worker; its process starts with the first call.

        Args:
            name: name of the process.
            first: function that is called in the process before anything else.
            shared: arguments of `first`; shared memory can be passed to a process only as it starts.
        """
        self._name, self._first = name, (first, shared)
        self._caller = ThreadPoolExecutor(1, name)  # waits for the process, so that calls queue
        self._guard = threading.Lock()
        self._calls: set[WorkerCall] = set()  # that are waited for
        self._current: WorkerCall | None = None
        self._process: SpawnProcess | None = None
        self._pipe: Connection | None = None
        self._ended = False

    def warm_up(self, function: Callable[..., object], *arguments: Any) -> None:
        """Queue a call that starts the process, such as one that loads modules for later calls; return at once.

        Its result or error is dropped.
        """
        self._caller.submit(self._run_call, WorkerCall(function, arguments, START_TIMEOUT, "the beginning"))

    async def call(
        self, function: Callable[..., Result], *arguments: Any, limit: float, what: str, by: object = None
    ) -> Result:
        """Call a function of a module in the process, and return its result.

        Args:
            function: imported there by its name, with arguments and a result that can be pickled.
            arguments: arguments of the function.
            limit: maximum time of the call, s.
            what: the work, for messages of errors, such as "the search for angles".
            by: caller, as for `cancel`.

        Raises:
            LayflatError: the function raised any error, the call took too long or was cancelled, the process has ended,
                or the worker is ended; an InputError of the function stays one.
        """
        call = WorkerCall(function, arguments, limit, what, by)
        self._calls.add(call)
        try:
            result: Result = await asyncio.get_running_loop().run_in_executor(self._caller, self._run_call, call)
        except RuntimeError:  # the caller takes nothing any more
            raise LayflatError(CLOSING_TEXT) from None
        finally:
            self._calls.discard(call)
        return result

    def cancel(self, by: object) -> None:
        """Cancel the calls of a caller: waiting calls, and a running one, which ends with the process.

        Calls of others are made in a new process. To be called in the event loop.
        """
        with self._guard:
            for call in self._calls:
                call.cancelled |= call.by is by
            if self._current is not None and self._current.cancelled:
                self._kill()

    def forget(self, by: object) -> None:
        """Cancel the waiting calls of a caller that was closed; its running call is completed."""
        with self._guard:
            for call in self._calls:
                call.cancelled |= call.by is by and call is not self._current

    def _run_call(self, call: WorkerCall) -> Any:
        """Return the result of a call, or raise its error; it blocks, and ends the process of a call over its limit.

        Raises:
            LayflatError: the call took too long or was cancelled, or its process has ended.
        """
        pipe, start_time = self._connect(call)
        try:
            pipe.send((call.function, call.arguments))
            if not pipe.poll(call.limit + start_time):
                self._kill()
                raise LayflatError(f"{call.what} took longer than {call.limit:g} s and was ended")
            result, error = pipe.recv()
        except (EOFError, OSError):
            self._kill()  # the rest of a process that has crashed
            if self._ended:
                raise LayflatError(CLOSING_TEXT) from None
            end = "was cancelled" if call.cancelled else "has ended with its process: try again"
            raise LayflatError(f"{call.what} {end}") from None
        finally:
            self._current = None
        if error is not None:
            raise error
        return result

    def _kill(self) -> None:
        """Kill the process, if there is one; the next call starts another."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()

    def end(self) -> None:
        """Kill the process and drop the waiting calls; later calls raise LayflatError."""
        self._ended = True
        self._caller.shutdown(wait=False, cancel_futures=True)
        with self._guard:
            self._kill()

    def _connect(self, call: WorkerCall) -> tuple[Connection, float]:
        """Return the pipe for a call, and the time that the process may take to start, s; start it if need be.

        Raises:
            LayflatError: the worker is ended, or the call was cancelled while it waited.
        """
        with self._guard:
            if self._ended:
                raise LayflatError(CLOSING_TEXT)
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
            return self._pipe, START_TIMEOUT


def _serve(pipe: Connection, first: Callable[..., object] | None, shared: tuple[Any, ...]) -> None:
    """Call the functions received until the other side is closed: main function of the process."""
    if first is not None:
        first(*shared)
    with suppress(EOFError, OSError):
        while True:
            function, arguments = pipe.recv()
            pipe.send(_call_and_catch(function, arguments))


def _call_and_catch(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, LayflatError | None]:
    """Return a function's result and None, or None and its error as a LayflatError that can be sent to a process."""
    try:
        return function(*arguments), None
    except InputError as error:  # errors with arguments of their own do not travel between processes by themselves
        return None, InputError(error.what, where=error.where, right=error.right)
    except LayflatError as error:
        return None, LayflatError(str(error))
    except Exception as error:  # a law or a library failed: the person is informed and continues
        return None, LayflatError(f"{function.__name__} failed ({type(error).__name__}: {error})")
