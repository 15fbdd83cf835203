"""What a check found."""

from __future__ import annotations

from typing import NamedTuple


class CheckResult(NamedTuple):
    """One thing that was looked at."""

    what: str
    found: str
    action: str = ""
    """What to do; empty where the check passed."""

    @property
    def passed(self) -> bool:
        """Whether nothing has to be done."""
        return not self.action
