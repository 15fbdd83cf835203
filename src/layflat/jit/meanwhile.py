"""What is otherwise while a kernel is compiled.

LLVM works on laws in a thread of its own, one after the other, while the compiler's own Python goes on with what comes
next: each takes about half of the time. Python's threads take turns more often meanwhile, since that thread comes back
to Python a thousand times a second. And garbage is collected less often, since what the compiler makes is nearly all
still in use.
"""

# mypy: disable-error-code="no-untyped-call,misc"
# The compiler's own modules are untyped.

import gc
import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from threading import get_ident
from typing import Any

from llvmlite.binding import ffi
from numba.core import event

SELDOM = (100_000, 50, 100)
"""Thresholds of the collector while compiling; Python's own take a sixth of the time of a large kernel."""

TURN = 1e-4  # s that a thread keeps Python while another waits for it; Python's own 5 ms make waiting take all the time


class _Meanwhile(event.Listener):
    """Laws are compiled while the kernel that calls them is: the outermost one counts. All hold the compiler's lock."""

    def __init__(self) -> None:
        self.depth = 0
        self.pool: ThreadPoolExecutor | None = None
        self.usual = gc.get_threshold(), sys.getswitchinterval()

    def on_start(self, _: Any) -> None:
        if self.depth == 0:
            self.usual = gc.get_threshold(), sys.getswitchinterval()
            gc.set_threshold(*SELDOM)
            sys.setswitchinterval(TURN)
            self.pool = ThreadPoolExecutor(1)
        self.depth += 1

    def on_end(self, _: Any) -> None:
        self.depth -= 1
        if self.depth == 0 and self.pool is not None:
            collected, turn = self.usual
            gc.set_threshold(*collected)
            sys.setswitchinterval(turn)
            pool, self.pool = self.pool, None
            # To the end, even when the kernel failed: its laws are kept, and others will call them.
            pool.shutdown()


_meanwhile = _Meanwhile()
event.register("numba:compile", _meanwhile)

# The compiler asks for these counts before and after each law. It only reads numbers, and would wait for LLVM's lock.
ffi.lib.LLVMPY_DumpRefPruneStats._lock = nullcontext()


class Work:
    """What LLVM does for a law: each part after the one before, and after what was begun earlier for other laws."""

    def __init__(self) -> None:
        self._last: Future[None] = Future()
        self._last.set_result(None)
        self._thread: int | None = None  # that does a part

    def add(self, part: Callable[..., None], *args: Any) -> None:
        """Do a part soon, unless one before it failed."""
        before = self._last

        def after() -> None:
            before.result()
            self._thread = get_ident()
            try:
                part(*args)
            finally:
                self._thread = None

        if _meanwhile.pool is None:
            after()
        else:
            self._last = _meanwhile.pool.submit(after)

    def wait(self) -> None:
        """Wait until all is done, unless it is a part that asks.

        Raises:
            Exception: what made a part fail.
        """
        if self._thread != get_ident():
            self._last.result()
