"""How fast the cell's clock goes: held to real time, or as fast as it computes; and how fast it went lately."""

import time
from collections import deque
from collections.abc import Callable
from math import nan

LAG = 0.5  # by which the cell may be behind and still catch up: more than an image takes, s
SPAN = 4.0  # over which the pace is measured, s


class Pace:
    """Compares the cell's clock with real time; `now` (s) and `sleep` are those of a clock that tests may replace."""

    def __init__(self, now: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep) -> None:
        self.now, self._sleep = now, sleep
        self._ahead_of = 0.0  # real time less the cell's, where both agree, s
        self._marks: deque[tuple[float, float]] = deque()
        self.begin()

    def begin(self) -> None:
        """Let the cell's clock go on from nought: a delivery begins."""
        self._ahead_of = self.now()
        self._marks.clear()

    def hold(self, cell: float, *, fast: bool) -> None:
        """Wait until real time is as far as the cell's (s since it began), unless it is to go fast."""
        ahead = cell + self._ahead_of - self.now()
        if fast or ahead < -LAG:
            self._ahead_of -= ahead
        elif ahead > 0.0:
            self._sleep(ahead)

    def measured(self, cell: float) -> float:
        """Return by which the cell's time went faster than real time lately; not a number at first."""
        now = self.now()
        self._marks.append((now, cell))
        while now - self._marks[0][0] > SPAN:
            self._marks.popleft()
        since, then = self._marks[0]
        return (cell - then) / (now - since) if now > since else nan
