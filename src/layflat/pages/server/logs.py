"""Messages to a person at a terminal while pages are served: a line each, no traceback.

Messages of libraries are cut to a line. Turns of the event loop are measured: in one turn a loop waits in its selector,
then calls all handlers that are due. While a turn lasts no button is answered, and no lease renewed.
"""

import logging
import sys
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from selectors import DefaultSelector, SelectorKey
from time import monotonic, thread_time
from traceback import extract_tb
from types import FrameType
from typing import NamedTuple

LOGGER_NAMES = ("nicegui", "asyncio", "engineio", "engineio.server", "socketio", "socketio.server", "layflat.pages")
MAX_LENGTH = 300  # characters of a line
REPEAT_INTERVAL = 1.0  # in which the same line is printed once, s
MAX_REMEMBERED_LINES = 256  # lines that are remembered
MAX_TURN_WORK = 0.05  # processor time of a turn that is not reported, s
MAX_TURN_DURATION = 0.2  # of a turn that is not reported, s: others may have the processor
PACKAGE_PREFIX = "layflat."


class OneLineHandler(logging.Handler):
    """Handler that writes a record as one line on stderr: its message, with type, text and source line of its error."""

    def __init__(self) -> None:
        super().__init__()
        self._printed: dict[str, float] = {}

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record, unless the same line was written within `REPEAT_INTERVAL`."""
        line, now = format_record(record), monotonic()
        if now - self._printed.get(line, -REPEAT_INTERVAL) < REPEAT_INTERVAL:
            return
        if len(self._printed) >= MAX_REMEMBERED_LINES:
            self._printed.clear()
        self._printed[line] = now
        print(f"layflat: {line}", file=sys.stderr, flush=True)  # noqa: T201


def format_record(record: logging.LogRecord) -> str:
    """Return the first line of a record's message, with type, text and source line of its error, as printable text.

    Text beyond `MAX_LENGTH` characters is replaced by "...".
    """
    text = record.getMessage().partition("\n")[0]
    error = record.exc_info[1] if record.exc_info else None
    if error is not None:
        frames = extract_tb(error.__traceback__)
        where = f" at {Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""
        kind = f"{type(error).__name__}: {error}".partition("\n")[0]
        text = f"{kind}{where}" if text == str(error).partition("\n")[0] else f"{text} ({kind}{where})"
    plain = "".join(char if char.isprintable() else " " for char in text)
    return plain if len(plain) <= MAX_LENGTH else plain[:MAX_LENGTH] + "..."


def log_in_lines() -> None:
    """Replace the handlers of the loggers in `LOGGER_NAMES` by one `OneLineHandler`; their records go nowhere else."""
    handler = OneLineHandler()
    for name in LOGGER_NAMES:
        logger = logging.getLogger(name)
        logger.handlers[:] = [handler]
        logger.propagate = False


class Turn(NamedTuple):
    """Turn of the event loop that is over.

    Attributes:
        start: start by `time.monotonic`, s.
        duration: s.
        work: processor time of the loop's thread in it, s.
        handler: qualified name of our function that the loop called, or of the library's; empty where unknown.
        inside: qualified name of the innermost of our functions, in the most frequent sample.
    """

    start: float
    duration: float
    work: float
    handler: str
    inside: str

    @property
    def is_slow(self) -> bool:
        """True where people at the pages notice the delay."""
        return self.work > MAX_TURN_WORK or self.duration > MAX_TURN_DURATION

    def __str__(self) -> str:
        """Return the message about the turn."""
        where = self.handler if self.inside in ("", self.handler) else f"{self.handler}, in {self.inside}"
        times = f"{1e3 * self.duration:.0f} ms ({1e3 * self.work:.0f} ms of them at work)"
        return f"the pages were held up for {times} by {where or 'an unknown handler'}"


class TurnMonitor(AbstractContextManager["TurnMonitor"]):
    """Monitor of the turns of a loop that uses its `selector`; a thread samples which handler takes long.

    Args:
        report: called in the loop's thread with each turn that is over.
        sampling: period of the samples, and time of a turn before the first, s.

    Attributes:
        reports: whether turns are reported; False at first.
    """

    def __init__(self, report: Callable[[Turn], object], *, sampling: float = 0.5 * MAX_TURN_WORK) -> None:
        """Start the thread that samples; the loop of this thread has to use `selector`."""
        self.reports = False
        self._report, self._sampling = report, sampling
        self._turn_start: float | None = None
        self._work = 0.0
        self._samples = Counter[tuple[str, str]]()
        self._loop_thread = threading.get_ident()
        self._over = threading.Event()
        self.selector = _TurnSelector(self)
        self._thread = threading.Thread(target=self._sample_handlers, name="layflat-turns", daemon=True)
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def begin_turn(self) -> None:
        """Store the start of a turn; called in the loop's thread."""
        self._loop_thread = threading.get_ident()
        self._work, self._turn_start = thread_time(), monotonic()

    def end_turn(self) -> None:
        """Report the turn that has ended with its most frequent sample, if one was begun and `reports` is True."""
        start, self._turn_start = self._turn_start, None
        if start is not None and self.reports:
            samples, self._samples = self._samples, Counter()
            names = samples.most_common(1)[0][0] if samples else ("", "")
            self._report(Turn(start, monotonic() - start, thread_time() - self._work, *names))

    def _sample_handlers(self) -> None:
        """Count the handler that runs at each sample of a turn longer than the period, until the monitor is closed."""
        while not self._over.wait(self._sampling):
            start = self._turn_start
            if start is None or monotonic() - start < self._sampling:
                continue
            frame = sys._current_frames().get(self._loop_thread)
            if frame is not None and self._turn_start == start:
                self._samples[_names(frame)] += 1


class _TurnSelector(DefaultSelector):
    """Selector that notifies a monitor when the loop stops waiting, and when it waits again."""

    def __init__(self, monitor: TurnMonitor) -> None:
        super().__init__()
        self._monitor = monitor

    def select(self, timeout: float | None = None) -> list[tuple[SelectorKey, int]]:
        """Return the ready events, as the base class does; the wait for them lies between two turns."""
        self._monitor.end_turn()
        ready = super().select(timeout)
        self._monitor.begin_turn()
        return ready


def _names(frame: FrameType | None) -> tuple[str, str]:
    """Return the qualified names of a turn's handler and of its innermost function; "" for both without a frame.

    They are names of this package, if the stack has one, else of libraries other than asyncio.
    """
    all_names: list[str] = []
    while frame is not None and frame.f_code.co_name != "_run_once":
        all_names.append(f"{frame.f_globals.get('__name__', '?')}.{frame.f_code.co_qualname}")
        frame = frame.f_back
    others = [name for name in all_names if not name.startswith("asyncio.")]
    ours = [name for name in all_names if name.startswith(PACKAGE_PREFIX)] or others or all_names
    return (ours[-1], ours[0]) if ours else ("", "")
