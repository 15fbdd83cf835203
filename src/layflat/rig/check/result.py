"""What a check found."""

from __future__ import annotations

from typing import NamedTuple


class CheckResult(NamedTuple):
    """One thing that was looked at."""

    what: str
    found: str
    right: str = ""
    """What to do; empty where all is well."""

    @property
    def sound(self) -> bool:
        """Whether all is well."""
        return not self.right
