"""The check of a rig, in a process of its own: its cycles must not wait for pages."""

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
from layflat.pages.panel.desk import Desk
from layflat.rig.check.all import check_rig
from layflat.rig.check.open_loop import CheckResult
from layflat.rig.clock import MonotonicClock
from layflat.rig.driver import Driver
from layflat.rig.system import first_in, start_process

LOOKS = 0.05  # between two looks whether somebody still minds the rig, s
ENDS = 5.0  # in which a check that is broken off lets out the air, s


class BrokenOffError(LayflatError):
    """A check was broken off."""


def checked(desk: Desk, *, air: bool, tell: Callable[[str], object]) -> list[CheckResult]:
    """Check the desk's rig, which has to be at rest, and return what was found; it blocks until then.

    Args:
        desk: it is without a rig meanwhile.
        air: whether joints are moved, too: then somebody has to mind the rig, or the check is broken off.
        tell: told what is being done, from this thread.

    Raises:
        LayflatError: the rig can't be had, or nobody minded it.
    """
    desk.link.lend()
    try:
        driver, _ = desk.rig.reached(desk.machine)
        mine, its = Pipe()
        process = start_process(_check, (desk.machine, driver, air, its), "layflat-check")
        its.close()
        try:
            while True:
                if mine.poll(LOOKS):
                    kind, what = mine.recv()
                    if kind == "found":
                        return list(what)
                    if kind == "failed":
                        raise LayflatError(what)
                    tell(what)
                if air and not desk.lease.lives:
                    raise BrokenOffError("broken off: nobody minded the rig, so its air was let out")
        except (EOFError, OSError):
            raise LayflatError(f"the check's process is gone (status {process.exitcode})") from None
        finally:
            process.terminate()
            process.join(ENDS)
            if process.is_alive():
                process.kill()
                process.join()
    finally:
        desk.link.take_back()


def _check(machine: Machine, driver: Callable[[], Driver], air: bool, pipe: Connection) -> None:
    """Main function of the process."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))  # so that the air is let out
    gc.freeze()
    gc.disable()
    with suppress(OSError, AttributeError):
        first_in()
    try:
        said: tuple[str, Any] = (
            "found",
            check_rig(machine, driver(), MonotonicClock(), air=air, tell=lambda text: pipe.send(("doing", text))),
        )
    except LayflatError as error:
        said = "failed", str(error)
    with suppress(OSError):
        pipe.send(said)
