"""Fewer collections of garbage while a kernel is compiled: what the compiler makes is nearly all still in use."""

# mypy: disable-error-code="no-untyped-call,misc"
# The compiler's own modules are untyped.

import gc
from typing import Any

from numba.core import event

SELDOM = (100_000, 50, 100)
"""Thresholds of the collector while compiling; Python's own take a sixth of the time of a large kernel."""


class _Collector(event.Listener):
    """Laws are compiled while the kernel that calls them is: the outermost one counts. All hold the compiler's lock."""

    def __init__(self) -> None:
        self.depth = 0
        self.usual = gc.get_threshold()

    def on_start(self, _: Any) -> None:
        if self.depth == 0:
            self.usual = gc.get_threshold()
            gc.set_threshold(*SELDOM)
        self.depth += 1

    def on_end(self, _: Any) -> None:
        self.depth -= 1
        if self.depth == 0:
            gc.set_threshold(*self.usual)


def collect_seldom() -> None:
    """Let the collector run less often during every compilation from now on."""
    event.register("numba:compile", _Collector())
