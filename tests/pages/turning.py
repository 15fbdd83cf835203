"""Turns of a served page's event loop, kept in a file while a test drives it."""

import json
import time
from pathlib import Path

from layflat.pages.server.logs import Turn

KEPT = """
import json, sys
import layflat.pages.server
serve = sys.modules["layflat.pages.server.serve"]
_kept = open("turns.jsonl", "a", buffering=1)
def keep(turn):
    if turn.duration > 5e-3:
        _kept.write(json.dumps(turn) + "\\n")
serve.report_slow_turn = keep
_monitor = serve.TurnMonitor
serve.TurnMonitor = lambda report: _monitor(report, sampling=4e-3)
"""
"""Before a command that serves a page: its turns are kept in its folder."""


class Turns:
    """Looks at the turns that were kept, time span by time span."""

    def __init__(self, folder: Path) -> None:
        self._file, self._since = folder / "turns.jsonl", time.monotonic()

    def begin(self) -> None:
        """Forget what was before."""
        self._since = time.monotonic()

    def longest(self) -> Turn:
        """The turn since `begin` in which the loop's thread worked longest: others on the computer do not count."""
        rows = [Turn(*json.loads(row)) for row in self._file.read_text(encoding="utf-8").splitlines()]
        found = [turn for turn in rows if turn.start + turn.duration >= self._since]
        return max(found, key=lambda turn: turn.work, default=Turn(self._since, 0.0, 0.0, "", ""))
