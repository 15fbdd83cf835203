"""Turns of an event loop: how long each one held up everything else, and which handler it was.

A loop waits in its selector for something to do, then calls all handlers that are due: one turn. While a turn lasts no
button is answered, and no lease renewed.
"""

import sys
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager
from selectors import DefaultSelector, SelectorKey
from time import monotonic, thread_time
from types import FrameType
from typing import NamedTuple

SLOW_TURN = 0.05  # processor time above which a turn is told, s
WAITED_TURN = 0.2  # time above which it is told although it worked little: others had the processor, s
OURS = "layflat."


class Turn(NamedTuple):
    """One turn of the loop that is over.

    Attributes:
        begun: by `time.monotonic`, s.
        duration: s.
        work: processor time of the loop's thread in it, s.
        handler: qualified name of our function that the loop called, or of the library's; empty where not known.
        inside: qualified name of the innermost of our functions then.
    """

    begun: float
    duration: float
    work: float
    handler: str
    inside: str

    @property
    def slow(self) -> bool:
        """True where people at the pages feel it."""
        return self.work > SLOW_TURN or self.duration > WAITED_TURN

    def __str__(self) -> str:
        """Return the line about it."""
        where = self.handler if self.inside in ("", self.handler) else f"{self.handler}, in {self.inside}"
        times = f"{1e3 * self.duration:.0f} ms ({1e3 * self.work:.0f} ms of them at work)"
        return f"the pages were held up for {times} by {where or 'an unknown handler'}"


class TurnMonitor(AbstractContextManager["TurnMonitor"]):
    """Measures all turns of a loop that has its `selector`; a thread beside it sees which handler takes long.

    Args:
        report: called in the loop's thread with each turn that is over.
        sampling: time after which a thread looks which handler it is, and between two looks, s.

    Attributes:
        reports: whether turns are reported, which they are not before this is set.
    """

    def __init__(self, report: Callable[[Turn], object], *, sampling: float = 0.5 * SLOW_TURN) -> None:
        self.reports = False
        self._report, self._sampling = report, sampling
        self._begun: float | None = None
        self._work = 0.0
        self._seen = Counter[tuple[str, str]]()
        self._loop_thread = threading.get_ident()
        self._over = threading.Event()
        self.selector = _TurnSelector(self)
        self._thread = threading.Thread(target=self._watch, name="layflat-turns", daemon=True)
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def begin(self) -> None:
        """Note that a turn begins, in the loop's thread."""
        self._loop_thread = threading.get_ident()
        self._work, self._begun = thread_time(), monotonic()

    def end(self) -> None:
        """Report the turn that has ended, if one has."""
        begun, self._begun = self._begun, None
        if begun is not None and self.reports:
            seen, self._seen = self._seen, Counter()
            names = seen.most_common(1)[0][0] if seen else ("", "")
            self._report(Turn(begun, monotonic() - begun, thread_time() - self._work, *names))

    def _watch(self) -> None:
        while not self._over.wait(self._sampling):
            begun = self._begun
            if begun is None or monotonic() - begun < self._sampling:
                continue
            frame = sys._current_frames().get(self._loop_thread)
            if frame is not None and self._begun == begun:
                self._seen[_names(frame)] += 1


class _TurnSelector(DefaultSelector):
    """A selector that tells a monitor when the loop stops waiting, and when it waits again."""

    def __init__(self, monitor: TurnMonitor) -> None:
        super().__init__()
        self._monitor = monitor

    def select(self, timeout: float | None = None) -> list[tuple[SelectorKey, int]]:
        self._monitor.end()
        found = super().select(timeout)
        self._monitor.begin()
        return found


def _names(frame: FrameType | None) -> tuple[str, str]:
    """Return the names of a turn's handler and of the innermost function, ours before those of libraries."""
    all_names: list[str] = []
    while frame is not None and frame.f_code.co_name != "_run_once":
        all_names.append(f"{frame.f_globals.get('__name__', '?')}.{frame.f_code.co_qualname}")
        frame = frame.f_back
    others = [name for name in all_names if not name.startswith("asyncio.")]
    ours = [name for name in all_names if name.startswith(OURS)] or others or all_names
    return (ours[-1], ours[0]) if ours else ("", "")
