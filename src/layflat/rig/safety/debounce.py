"""Conditions that count only once they last: by samples, or by time."""

from __future__ import annotations


class CountDebounce:
    """True when a condition held in so many samples, one after the other."""

    __slots__ = ("count", "enough")

    def __init__(self, enough: int) -> None:
        self.enough, self.count = enough, 0

    def __call__(self, condition: bool) -> bool:
        """Whether it has held often enough, this sample included."""
        self.count = self.count + 1 if condition else 0
        return self.count >= self.enough


class TimeDebounce:
    """True when a condition held for some time (s)."""

    __slots__ = ("enough", "time")

    def __init__(self, enough: float) -> None:
        self.enough, self.time = enough, 0.0

    def __call__(self, condition: bool, elapsed: float) -> bool:
        """Whether it has held long enough; `elapsed` (s) is the time since the sample before."""
        self.time = self.time + elapsed if condition else 0.0
        return self.time >= self.enough
