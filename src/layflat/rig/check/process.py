"""The check of a rig in a process of its own: its cycles wait for nobody, and nobody else is left with its priority."""

import gc
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.parallel import start_process
from layflat.rig.check.all import check_rig
from layflat.rig.check.open_loop import CheckResult
from layflat.rig.clock import MonotonicClock
from layflat.rig.driver import Driver
from layflat.rig.system import first_in

LOOKS = 0.05  # between two looks whether to go on, s
ENDS = 15.0  # in which a check that is broken off lets out the air, s


def checked(
    machine: Machine, driver: Callable[[], Driver], *, air: bool, tell: Callable[[str], object],
    minded: Callable[[], bool] = lambda: True,
) -> list[CheckResult]:  # fmt: skip
    """Check a rig as `check_rig` does, and return what was found; it blocks until then.

    Args:
        machine: what the rig is.
        driver: makes its driver in the process, so it must be picklable.
        air: whether joints are moved, too.
        tell: told what is being done.
        minded: whether to go on; where it is not so, the check is broken off and the air let out.

    Raises:
        LayflatError: nothing that fits is there, or the check was broken off; its message says so.
    """
    mine, its = Pipe()
    process = start_process(_check, (machine, driver, air, its), "layflat-check")
    its.close()
    try:
        while minded():
            if mine.poll(LOOKS):
                kind, what = mine.recv()
                if kind == "found":
                    return list(what)
                if kind == "failed":
                    raise LayflatError(what)
                tell(what)
        raise LayflatError("the check was broken off, and the air let out")
    except (EOFError, OSError):
        process.join(0.1)  # so that its status is known
        raise LayflatError(f"the check's process is gone (status {process.exitcode})") from None
    finally:
        process.terminate()
        process.join(ENDS)
        if process.is_alive():
            process.kill()
            process.join()


def _check(machine: Machine, driver: Callable[[], Driver], air: bool, pipe: Connection) -> None:
    """Main function of the process."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))  # so that the air is let out
    gc.freeze()
    gc.disable()  # a collection takes many cycles
    with suppress(OSError, AttributeError):
        first_in()
    try:
        said: tuple[str, Any] = (
            "found",
            check_rig(machine, driver(), MonotonicClock(), air=air, tell=lambda text: pipe.send(("doing", text))),
        )
    except LayflatError as error:
        said = "failed", str(error)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # it ends by itself, and Python's own end must not be broken off
    with suppress(OSError):
        pipe.send(said)
