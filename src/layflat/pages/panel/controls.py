"""Commands of one page to the rig, each refused unless it drives and the rig may be had; and the check of the rig."""

from collections.abc import Callable, Sequence

from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.pages.panel.desk import Desk
from layflat.pages.panel.moves import Step
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


NOT_DRIVING = "This page looks on: press Drive from here first."
NOT_OBEYING = "The rig does not obey now: see State."


class Controls:
    """The hand of one page at the rig.

    That a button can be pressed only while its page drives is not enough: a page shows what was so a moment ago, a
    question may have been open for long, and a message need not come from a button.

    Attributes:
        share: of what the arm can do, at which moves of this page go, 0..1.
    """

    def __init__(self, desk: Desk, key: str, share: float) -> None:
        """Take the desk, and the key of the page."""
        self.share = share
        self._desk, self._key = desk, key

    @property
    def drives(self) -> bool:
        """True while this page drives."""
        return self._desk.operators.drives(self._key)

    def start(self) -> None:
        """Bring the air, or go on after the joints were held."""
        if self.drives:
            self._desk.pilot.start()

    def stop(self) -> None:
        """Hold the joints where they are, with air."""
        if self.drives:
            self._desk.pilot.stop()
            self._desk.rounds.hurry()

    def vent(self) -> None:
        """Hold the joints, then let out the air."""
        if self.drives:
            self._desk.pilot.vent()

    def reset(self) -> None:
        """Reset faults that are over."""
        if self.drives:
            self._desk.pilot.reset()

    def switch(self, output: str, on: bool) -> None:
        """Switch a digital output of the machine."""
        if self.drives:
            self._desk.pilot.switch(output, on)

    def jog(self, velocities: Sequence[float]) -> None:
        """Move joints by these speeds, rad/s, from now until they are asked for zero."""
        if self.drives:
            self._desk.pilot.jog(velocities)

    def go(self, steps: Sequence[Step], *, repeats: bool = False) -> None:
        """Move through places from where the joints are.

        Raises:
            LayflatError: the page looks on, the rig does not obey, or there are no places.
        """
        if not steps:
            raise LayflatError("There are no steps: add some.")
        self._require_drive()
        if not self._desk.pilot.go(steps, share=self.share, repeats=repeats):
            raise LayflatError(NOT_OBEYING)

    def change(self, machine: Machine) -> None:
        """Go on with another controller.

        Raises:
            LayflatError: the page looks on, or the rig is not at rest.
        """
        self._require_drive()
        self._desk.link.change(machine)

    def check(self, *, air: bool, tell: Callable[[str], object]) -> list[CheckResult]:
        """Return what a check of the rig finds, as `checked_at`; it blocks until then.

        Raises:
            LayflatError: the page looks on, the rig is not at rest or can't be had, or nobody minded it.
        """
        self._require_drive()
        return checked_at(self._desk, air=air, tell=tell)

    def _require_drive(self) -> None:
        if not self.drives:
            raise LayflatError(NOT_DRIVING)
