"""The check of a panel's rig, which the panel does without meanwhile."""

from collections.abc import Callable

from layflat.pages.panel.desk import Desk
from layflat.rig.check.open_loop import CheckResult
from layflat.rig.check.process import checked


def checked_at(desk: Desk, *, air: bool, tell: Callable[[str], object]) -> list[CheckResult]:
    """Check the desk's rig and return what was found; it blocks until then.

    Args:
        desk: it is without a rig meanwhile.
        air: whether joints are moved, too: then somebody has to mind the rig, or the check is broken off.
        tell: told what is being done, from this thread.

    Raises:
        LayflatError: the rig is not at rest or can't be had, another check has it, or nobody minded it.
    """
    desk.link.lend()
    try:
        driver, _ = desk.rig.reached(desk.machine)
        return checked(desk.machine, driver, air=air, tell=tell, minded=lambda: not air or desk.lease.lives)
    finally:
        desk.link.take_back()
