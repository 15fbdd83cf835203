"""All that the panel's pages share: the rig, who drives it, and what it is asked to do."""

from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from layflat.description.tables import Plain
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.machine.loader import tables
from layflat.motion.inverse import Inverse
from layflat.pages.look.rounds import Rounds
from layflat.pages.panel.history import Seen
from layflat.pages.panel.link import Reached, RigLink, Standing
from layflat.pages.panel.operators import Operators
from layflat.pages.panel.pilot import Pilot
from layflat.pages.panel.search import prepare
from layflat.pages.server.worker import Worker
from layflat.rig.lease import Lease
from layflat.rig.session import Snapshot

Data = dict[str, list[list[float]]]
"""Pairs of coordinates of lines, by their names."""


def written_values(machine: Machine) -> Plain:
    """Return the values of a machine as its description has them, with their units; none where it can't be read."""
    with suppress(LayflatError):
        return tables(machine.origin)[0]
    return {}


@dataclass(frozen=True)
class Rig:
    """Rig of a panel."""

    reached: Reached
    address: str  # for people
    tell: Callable[[str], str] | None = None  # of a virtual rig: obeys a line such as "fail e-stop", and answers


class Desk(AbstractContextManager["Desk"]):
    """The desk behind all pages of one panel: `with Desk(machine, rig, folder) as desk: ...`.

    Logs and sequences are kept in the folder.

    Attributes:
        first: the machine as described.
        extent: least and greatest coordinates of the tip in the frame of the base, (2, 3), m.
        inverse: inverse kinematics of its arm, ready for what takes no time: searches are the worker's.
        written: values of the description as its file has them, with their units.
        worker: does what takes longer than an event loop may be held up.
        painter: draws logs, which may take long.
        charts: what the charts of all pages show, by their names, and what was seen then.
    """

    def __init__(self, machine: Machine, rig: Rig, folder: Path) -> None:
        self.rig, self.folder, self.lease = rig, folder, Lease()
        self.first = machine
        self.worker, self.painter = Worker("layflat-panel-worker"), Worker("layflat-panel-plots")
        self.worker.begin(prepare, machine)
        self.inverse = Inverse(machine)
        self.written = written_values(machine)
        self.extent = np.array([self.inverse.tips.min(axis=0), self.inverse.tips.max(axis=0)])
        self.inverse.tip(np.zeros(self.inverse.joints))  # loads what it calls
        self.link = RigLink(machine, rig.reached, folder, self.lease)
        self.pilot, self.operators = Pilot(self.link, self.lease), Operators(self.lease)
        self.charts: dict[str, tuple[Seen, Data]] = {}
        self.rounds = Rounds(self.operators.drives)

    @property
    def machine(self) -> Machine:
        """Machine of the rig, with its present controller."""
        return self.link.machine

    def snapshot(self) -> Snapshot | None:
        """The last cycle; None while the rig is not there."""
        return self.link.snapshot()

    @property
    def is_open(self) -> bool:
        """True while the rig is connected."""
        return self.link.standing is Standing.OPEN

    def close(self) -> None:
        """Stop the rig, let out the air, finish the log."""
        self.worker.end()
        self.painter.end()
        self.pilot.close()
        self.link.close()

    def __exit__(self, *_: object) -> None:
        self.close()
