"""Desk of a panel: the rig, its operators and their commands, shared by all pages."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from layflat.description.tables import Plain
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.machine.loader import tables
from layflat.motion.inverse import InverseKinematics
from layflat.pages.look.pieces import Rounds
from layflat.pages.panel.link import RigConnector, RigLink
from layflat.pages.panel.moves import SequenceStep
from layflat.pages.panel.operators import Operators
from layflat.pages.panel.pilot import Pilot, RecentSamples
from layflat.pages.panel.search import prepare_search
from layflat.pages.panel.solids import ArmSolids
from layflat.pages.server.worker import ProcessWorker
from layflat.rig.check import check_in_subprocess
from layflat.rig.open_loop import CheckResult
from layflat.rig.session import HostLease, RigSnapshot

ChartData = dict[str, list[list[float]]]
"""Pairs (x, y) of the lines of a chart, by their names."""
NOT_DRIVING = "This page looks on: press Drive from here first."
NOT_OBEYING = "The rig does not obey now: see State."


def written_values(machine: Machine) -> Plain:
    """Return the values of a machine as its description has them, with their units; {} where it can't be read."""
    with suppress(LayflatError):
        return tables(machine.origin)[0]
    return {}


@dataclass(frozen=True)
class PanelRig:
    """Rig of a panel: connection, address, and commands to a virtual one."""

    connect: RigConnector
    address: str  # for people
    send_line: Callable[[str], str] | None = (
        None  # of a virtual rig: performs a line such as "fail e-stop", and answers
    )


class Desk(AbstractContextManager["Desk"]):
    """Desk behind all pages of one panel: `with Desk(machine, rig, folder) as desk: ...`.

    Logs and sequences are kept in the folder.

    Attributes:
        first: the machine as described.
        extent: min and max coordinates of the tip in the base frame, (2, 3), m.
        inverse: inverse kinematics of the arm, for short calls; searches are made by the worker.
        written: values of the description as its file has them, with their units.
        worker: process for calls that take longer than an event loop may be held up.
        painter: process that draws logs, which may take long.
        solids: solids of the arm.
        charts: lines of all charts by the charts' names, with the samples that they were made of.
    """

    def __init__(self, machine: Machine, rig: PanelRig, folder: Path) -> None:
        """Start worker process, link to the rig and pilot; the link connects by itself."""
        self.rig, self.folder, self.lease = rig, folder, HostLease()
        self.first = machine
        self.worker, self.painter = ProcessWorker("layflat-panel-worker"), ProcessWorker("layflat-panel-plots")
        self.worker.warm_up(prepare_search, machine)
        self.inverse = InverseKinematics(machine)
        self.written = written_values(machine)
        self.extent = np.array([self.inverse.tips.min(axis=0), self.inverse.tips.max(axis=0)])
        self.inverse.tip(np.zeros(self.inverse.joints))  # loads what it calls
        self.link = RigLink(machine, rig.connect, folder, self.lease)
        self.pilot, self.operators = Pilot(self.link, self.lease), Operators(self.lease)
        self.charts: dict[str, tuple[RecentSamples, ChartData]] = {}
        self.rounds = Rounds(self.operators.drives)
        self.solids = ArmSolids(machine, self.snapshot)

    @property
    def machine(self) -> Machine:
        """Machine of the rig, with its present controller."""
        return self.link.machine

    def snapshot(self) -> RigSnapshot | None:
        """Return the last cycle; None while the rig is not connected."""
        return self.link.snapshot()

    def close(self) -> None:
        """End the worker processes and the pilot, stop the rig, vent the air, finish the log; it blocks until then."""
        self.worker.end()
        self.painter.end()
        self.solids.end()
        self.pilot.close()
        self.link.close()

    def __exit__(self, *_: object) -> None:
        self.close()


def run_check(desk: Desk, *, air: bool, tell: Callable[[str], object]) -> list[CheckResult]:
    """Check the desk's rig and return the results; it blocks until then.

    Args:
        desk: desk whose rig is lent to the check.
        air: whether joints are moved, too: then the lease must stay alive, or the check is aborted.
        tell: called with status texts, from this thread.

    Raises:
        LayflatError: the rig is not at rest or can't be connected, another check has it, or the lease lapsed.
    """
    desk.link.lend()
    try:
        driver, _ = desk.rig.connect(desk.machine)
        return check_in_subprocess(
            desk.machine, driver, air=air, tell=tell, minded=lambda: not air or desk.lease.active
        )
    finally:
        desk.link.reconnect()


class Controls:
    """Commands of one page to the rig, carried out only while the page drives.

    Disabled buttons are not enough: a page shows a state that is a moment old, a question may have been open for long,
    and a message need not come from a button.

    Attributes:
        share: speed of this page's moves, as a fraction of the arm's limits, 0..1.
    """

    def __init__(self, desk: Desk, key: str, share: float) -> None:
        """Store the desk, the key of the page, and the speed of its moves."""
        self.share = share
        self._desk, self._key = desk, key

    @property
    def drives(self) -> bool:
        """True while this page drives."""
        return self._desk.operators.drives(self._key)

    def start(self) -> None:
        """Request the air, or to go on after the joints were held, if this page drives."""
        if self.drives:
            self._desk.pilot.start()

    def hold(self) -> None:
        """End the motion and hold the joints where they are, with air, if this page drives."""
        if self.drives:
            self._desk.pilot.hold()
            self._desk.rounds.hurry()

    def controlled_stop(self) -> None:
        """End the motion, hold the joints, then vent the air, if this page drives."""
        if self.drives:
            self._desk.pilot.controlled_stop()

    def reset(self) -> None:
        """Reset faults that are over, if this page drives."""
        if self.drives:
            self._desk.pilot.reset()

    def switch(self, output: str, on: bool) -> None:
        """Switch a digital output of the machine, if this page drives."""
        if self.drives:
            self._desk.pilot.switch(output, on)

    def jog(self, velocities: Sequence[float]) -> None:
        """Move joints at these velocities, rad/s, (joints,), until zero is demanded, if this page drives."""
        if self.drives:
            self._desk.pilot.jog(velocities)

    def start_sequence(self, steps: Sequence[SequenceStep], *, repeats: bool = False) -> None:
        """Move through the steps of a sequence, from the present configuration.

        Raises:
            LayflatError: the page looks on, the rig does not obey, or there are no steps.
        """
        if not steps:
            raise LayflatError("There are no steps: add some.")
        self._require_drive()
        if not self._desk.pilot.start_sequence(steps, share=self.share, repeats=repeats):
            raise LayflatError(NOT_OBEYING)

    def change(self, machine: Machine) -> None:
        """Use another controller.

        Raises:
            LayflatError: the page looks on, or the rig is not at rest.
        """
        self._require_drive()
        self._desk.link.change(machine)

    def check(self, *, air: bool, tell: Callable[[str], object]) -> list[CheckResult]:
        """Check the rig and return the results, as `run_check`; it blocks until then.

        Raises:
            LayflatError: the page looks on, the rig is not at rest or can't be connected, or the lease lapsed.
        """
        self._require_drive()
        return run_check(self._desk, air=air, tell=tell)

    def _require_drive(self) -> None:
        if not self.drives:
            raise LayflatError(NOT_DRIVING)
