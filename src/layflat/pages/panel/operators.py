"""Operators of a panel: one page drives at a time, others look on; control is handed over explicitly."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from layflat.rig.session import HostLease

OPERATOR_TIMEOUT = 3.0  # without a renewal, after which a page drives no more, s
FIRST_CONTACT_TIMEOUT = 30.0  # for the first renewal of a page that drives, s
MAX_BEAT_AGE = 0.4  # of the beat that a valid renewal names, s
MIN_BEAT_PERIOD, MAX_BEATS = 0.02, 64  # between two beats, s, and number of beats remembered


@dataclass
class Visitor:
    """Open page of a panel."""

    key: str
    name: str  # for others to read
    on_drive: Callable[[], object] = lambda: None  # called once it drives


class Operators:
    """Open pages, at most one of which drives; its renewals keep the lease alive.

    A renewal names the last beat that its page has received. A renewal that is delayed, as by a network, names an old
    beat, and renews nothing.
    """

    def __init__(self, lease: HostLease) -> None:
        """Begin without pages; `lease` is that of the rig."""
        self._lease, self._guard = lease, threading.RLock()
        self._visitors: dict[str, Visitor] = {}
        self._operator: str | None = None
        self._silent_at = 0.0  # time at which the driving page loses control without a renewal, s, monotonic
        self._count = 0
        self._beats: dict[int, float] = {}
        self.requested_by: Visitor | None = None  # page that requests control

    def register(self, key: str, on_drive: Callable[[], object] = lambda: None) -> Visitor:
        """Register a page that was opened, and return it; it drives if no other does.

        Args:
            key: key of the page.
            on_drive: called each time the page gets control, maybe before this returns.
        """
        with self._guard:
            self._count += 1
            visitor = self._visitors[key] = Visitor(key, f"page {self._count}", on_drive)
            if self.operator is None:
                self._set_operator(key)
            return visitor

    def leave(self, key: str) -> None:
        """Remove a page that was closed, with its request for control; if it drove, no page drives."""
        with self._guard:
            self._visitors.pop(key, None)
            if self._operator == key:
                self._operator = None
            if self.requested_by is not None and self.requested_by.key == key:
                self.requested_by = None

    @property
    def operator(self) -> Visitor | None:
        """Page that drives; None where none does or its renewals have stopped."""
        with self._guard:
            if self._operator is not None and time.monotonic() > self._silent_at:
                self._operator = None
            return self._visitors.get(self._operator) if self._operator is not None else None

    def drives(self, key: str) -> bool:
        """Return whether a page drives."""
        operator = self.operator
        return operator is not None and operator.key == key

    @property
    def others(self) -> int:
        """Number of pages that look on."""
        with self._guard:
            return len(self._visitors) - (self.operator is not None)

    def take_control(self, key: str) -> bool:
        """Take control if no page has it, else request it from the page that drives; return whether it drives."""
        with self._guard:
            if self.operator is None and key in self._visitors:
                self._set_operator(key)
            elif not self.drives(key):
                self.requested_by = self._visitors.get(key)
            return self.drives(key)

    def hand_over(self, key: str) -> None:
        """Hand control over to the page that requests it, if this page drives."""
        with self._guard:
            if self.drives(key) and self.requested_by is not None:
                self._set_operator(self.requested_by.key)

    def refuse_request(self, key: str) -> None:
        """Reject the request for control, if this page drives."""
        with self._guard:
            if self.drives(key):
                self.requested_by = None

    def beat(self) -> int:
        """Return the number of the present beat, which renewals send back; pages share it for `MIN_BEAT_PERIOD`."""
        with self._guard:
            number, now = max(self._beats, default=0), time.monotonic()
            if not self._beats or now - self._beats[number] >= MIN_BEAT_PERIOD:
                number += 1
                self._beats[number] = now
                self._beats.pop(number - MAX_BEATS, None)
            return number

    def renew(self, key: str, beat: int) -> bool:
        """Renew the lease for a page that drives and names a beat sent at most `MAX_BEAT_AGE` ago.

        Return whether it was renewed.
        """
        with self._guard:
            sent_at = self._beats.get(beat)
            if sent_at is None or time.monotonic() - sent_at > MAX_BEAT_AGE or not self.drives(key):
                return False
            self._silent_at = time.monotonic() + OPERATOR_TIMEOUT
            self._lease.renew()
            return True

    def _set_operator(self, key: str) -> None:
        """Make a registered page the operator, drop the request for control, and call the page's `on_drive`."""
        self._operator, self._silent_at, self.requested_by = key, time.monotonic() + FIRST_CONTACT_TIMEOUT, None
        self._visitors[key].on_drive()
