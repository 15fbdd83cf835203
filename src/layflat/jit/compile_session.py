"""State of the process during the compilation of a kernel.

LLVM works on laws in a thread of its own, one after the other, while numba's Python code goes on: each takes about half
of the time. Python switches threads more often during compilation, since that thread returns to Python a thousand times
a second. And garbage is collected less often, since nearly all objects of the compiler are still in use.
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

from numba.core import event

from layflat.jit.internals import ffi

GC_THRESHOLDS = (100_000, 50, 100)
"""Thresholds of the garbage collector during compilation; Python's own take a sixth of the time of a large kernel."""

SWITCH_INTERVAL = 1e-4  # of Python's threads during compilation, s: with its own 5 ms, waiting takes most of the time


class _CompilationListener(event.Listener):
    """Listener of nested compilations, of which the outermost sets the state. All hold the compiler's lock."""

    def __init__(self) -> None:
        self.depth = 0
        self.pool: ThreadPoolExecutor | None = None
        self.usual = gc.get_threshold(), sys.getswitchinterval()

    def on_start(self, _: Any) -> None:
        """Start the LLVM thread and relax garbage collection and thread switching, at the outermost compilation."""
        if self.depth == 0:
            self.usual = gc.get_threshold(), sys.getswitchinterval()
            gc.set_threshold(*GC_THRESHOLDS)
            sys.setswitchinterval(SWITCH_INTERVAL)
            self.pool = ThreadPoolExecutor(1)
        self.depth += 1

    def on_end(self, _: Any) -> None:
        """Restore the settings and wait for the LLVM thread, at the end of the outermost compilation."""
        self.depth -= 1
        if self.depth == 0 and self.pool is not None:
            collected, turn = self.usual
            gc.set_threshold(*collected)
            sys.setswitchinterval(turn)
            pool, self.pool = self.pool, None
            # Wait even if the kernel failed: its laws stay compiled for others.
            pool.shutdown()


_compilation = _CompilationListener()
event.register("numba:compile", _compilation)

# The compiler asks for these counts before and after each law. It only reads numbers, and would wait for LLVM's lock.
ffi.lib.LLVMPY_DumpRefPruneStats._lock = nullcontext()


class LlvmWork:
    """Work of LLVM on a law: parts in sequence, after earlier parts of other laws."""

    def __init__(self) -> None:
        self._last: Future[None] = Future()
        self._last.set_result(None)
        self._thread: int | None = None  # identity of the thread that runs a part

    def add(self, part: Callable[..., None], *args: Any) -> None:
        """Queue a part for the LLVM thread, or run it now if no compilation is on; none runs after one that failed."""
        before = self._last

        def run_part() -> None:
            before.result()
            self._thread = get_ident()
            try:
                part(*args)
            finally:
                self._thread = None

        if _compilation.pool is None:
            run_part()
        else:
            self._last = _compilation.pool.submit(run_part)

    def wait(self) -> None:
        """Wait for all parts; return at once if a part calls this.

        Raises:
            Exception: of a part that failed.
        """
        if self._thread != get_ident():
            self._last.result()
