"""A virtual arm that a visitor of the panel keeps moving, and what its server does meanwhile."""

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.pages.browsers import served
from tests.pages.turning import KEPT, Turns
from tests.pages.visitor import Visitor

OBEYS = {"Ready", "Moving"}
PATIENCE = 8.0  # without a renewal, where the time until a lease lapses is that of PATIENT, s
ANSWERED = 0.1  # from Stop to the page that tells it, s
LAPSES = """
import time
from layflat.rig import session as _session
_gaps = open("gaps.jsonl", "a", buffering=1)
def _renew(self):
    age = self.age
    self._renewed = time.monotonic()
    if age > 0.5 * _session.HELD_AFTER:
        _gaps.write(json.dumps([self._renewed, age if age < 1e9 else 0.0]) + "\\n")
_session.HostLease.renew = _renew
"""
"""After KEPT, before a command that serves a panel: long times between two renewals of the lease are kept, too."""


def obeys(visitor: Visitor) -> bool:
    """Bring the air, or go on: a computer that is busy with something else may hold the arm at any time."""
    state = visitor.text_of("lf-state")
    name = {"Fault": "Reset", "Holding": "Go on"}.get(state, "Start")
    if state not in OBEYS and any(visitor.named(name)) and visitor.enabled(name):
        visitor.press(name)
        time.sleep(0.3)
    return state in OBEYS


def moving(visitor: Visitor) -> bool:
    """Let the arm go to and fro; whether it does."""
    if obeys(visitor) and visitor.text_of("lf-state") == "Ready" and visitor.enabled("Run again and again"):
        visitor.press("Run again and again")
        time.sleep(0.3)
    return visitor.text_of("lf-state") == "Moving"


@contextmanager
def moved(folder: Path, before: str = KEPT) -> Iterator[tuple[Visitor, Turns]]:
    """A visitor that drives a picking arm to and fro, and the turns of its server."""
    with served(folder, "panel", "picking-arm", before=before) as found, Visitor(found.link) as visitor:
        turns = Turns(folder)
        visitor.until(lambda: any(visitor.named("Failures")) and visitor.text_of("lf-state") == "Off", 300.0)
        visitor.until(lambda: obeys(visitor), 60.0)
        visitor.press("Add present angles")
        visitor.jogs = ["0:1"]
        time.sleep(1.5)
        visitor.jogs = []
        time.sleep(0.5)
        visitor.press("Add present angles")
        visitor.until(lambda: moving(visitor), 60.0)
        yield visitor, turns


def longest_gap(folder: Path, since: float) -> float:
    """The longest time between two renewals of the lease since an instant, s."""
    rows = [json.loads(row) for row in (folder / "gaps.jsonl").read_text(encoding="utf-8").splitlines()]
    return max((age for at, age in rows if at > since), default=0.0)
