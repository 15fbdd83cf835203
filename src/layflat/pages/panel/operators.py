"""Operators of a panel: one person drives at a time, on one page; others look on. Handing over is explicit."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from layflat.rig.lease import Lease

FORGOTTEN = 3.0  # an operator whose page has been silent for so long is none any more, s
APPEARS = 30.0  # in which a page that was opened has to be heard first, s
FRESH = 0.4  # a renewal counts if its page had heard from here so shortly before, s
BEAT, BEATS = 0.02, 64  # shortest time from one to the next, s, and how many are remembered


@dataclass
class Visitor:
    """A page that is open."""

    key: str
    name: str  # for others to read
    told: Callable[[], object] = lambda: None  # called once it drives


class Operators:
    """The pages that are open, and which of them drives; its renewals keep the lease alive.

    A renewal names the last beat that its page has seen. What was written long ago and comes late, as when a network is
    back, names an old one, and renews nothing.
    """

    def __init__(self, lease: Lease) -> None:
        self._lease, self._guard = lease, threading.RLock()
        self._visitors: dict[str, Visitor] = {}
        self._operator: str | None = None
        self._silent_from = 0.0  # when an operator's page that is not heard again is silent, s, monotonic
        self._count = 0
        self._beats: dict[int, float] = {}
        self.asked_by: Visitor | None = None  # who would like to drive

    def come(self, key: str, told: Callable[[], object] = lambda: None) -> Visitor:
        """A page was opened; the first one drives, and whoever drives is told so."""
        with self._guard:
            self._count += 1
            visitor = self._visitors[key] = Visitor(key, f"page {self._count}", told)
            if self.operator is None:
                self._give(key)
            return visitor

    def leave(self, key: str) -> None:
        """A page was closed."""
        with self._guard:
            self._visitors.pop(key, None)
            if self._operator == key:
                self._operator = None
            if self.asked_by is not None and self.asked_by.key == key:
                self.asked_by = None

    @property
    def operator(self) -> Visitor | None:
        """Visitor who drives; None where that page has been silent for long."""
        with self._guard:
            if self._operator is not None and time.monotonic() > self._silent_from:
                self._operator = None
            return self._visitors.get(self._operator) if self._operator is not None else None

    def drives(self, key: str) -> bool:
        """Return whether a page drives."""
        operator = self.operator
        return operator is not None and operator.key == key

    @property
    def others(self) -> int:
        """Pages that look on."""
        with self._guard:
            return len(self._visitors) - (self.operator is not None)

    def take(self, key: str) -> bool:
        """Drive from this page, if nobody does; else its wish is shown to who drives. Returns whether it drives."""
        with self._guard:
            if self.operator is None and key in self._visitors:
                self._give(key)
            elif not self.drives(key):
                self.asked_by = self._visitors.get(key)
            return self.drives(key)

    def hand_over(self, key: str) -> None:
        """Hand over to the visitor who asked, if this page drives."""
        with self._guard:
            if self.drives(key) and self.asked_by is not None:
                self._give(self.asked_by.key)

    def keep(self, key: str) -> None:
        """Go on driving, if this page drives: whoever asked is told no more."""
        with self._guard:
            if self.drives(key):
                self.asked_by = None

    def beat(self) -> int:
        """A number, to be sent back with renewals; pages that ask at the same time share it."""
        with self._guard:
            number, now = max(self._beats, default=0), time.monotonic()
            if not self._beats or now - self._beats[number] >= BEAT:
                number += 1
                self._beats[number] = now
                self._beats.pop(number - BEATS, None)
            return number

    def renew(self, key: str, beat: int) -> bool:
        """A page is there, and has seen this beat; returns whether the lease was renewed by it."""
        with self._guard:
            seen = self._beats.get(beat)
            if seen is None or time.monotonic() - seen > FRESH or not self.drives(key):
                return False
            self._silent_from = time.monotonic() + FORGOTTEN
            self._lease.renew()
            return True

    def _give(self, key: str) -> None:
        self._operator, self._silent_from, self.asked_by = key, time.monotonic() + APPEARS, None
        self._visitors[key].told()
