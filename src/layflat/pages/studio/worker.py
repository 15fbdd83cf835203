"""Processes that work for all tabs of the studio: of each tab only the newest design is simulated to its end."""

from itertools import count
from multiprocessing import get_context
from multiprocessing.sharedctypes import SynchronizedArray
from typing import Any

from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.pages.server.worker import Worker as Beside
from layflat.pages.studio.cloud import Cloud, OvertakenError, Step, Tolerances, cloud

TABS = 256  # that are told apart; more share a number, and may overtake each other
LONGEST_CLOUD = 600.0  # time of a simulation, the compiling of its kernel included, s

_wanted: dict[str, Any] = {}
"""In the process that simulates: the number of the newest request of each tab."""


class Worker:
    """Two processes, begun with the first request, or again if they end: one simulates, one does all else."""

    def __init__(self) -> None:
        self.beside = Beside("layflat-studio")  # for what takes less than a cloud, and must not wait for one
        self._newest: SynchronizedArray[int] = get_context("spawn").Array("Q", TABS)
        self._simulator = Beside("layflat-studio-runs", first=_share, shared=(self._newest,))
        self._tabs = count()

    def tab(self) -> int:
        """Return a number for a tab."""
        return next(self._tabs) % TABS

    def begin(self) -> None:
        """Begin the process that simulates, so that it is ready when it is needed."""
        self._simulator.begin(_nothing)

    def overtake(self, tab: int, number: int) -> None:
        """End requests of a tab that are older than a number, without a result."""
        self._newest[tab] = number

    async def cloud(
        self, tab: int, number: int, machine: Machine, step: Step, tolerances: Tolerances
    ) -> Cloud | LayflatError | None:
        """Return the cloud of a machine; the error that it ends with; or None where it was overtaken.

        Args:
            tab: whose request it is.
            number: of the request; the tab's numbers grow.
            machine: that is simulated.
            step: what it does.
            tolerances: how far runs differ.
        """
        self.overtake(tab, number)
        given = tab, number, machine, step, tolerances
        try:
            return await self._simulator.call(_cloud, *given, limit=LONGEST_CLOUD, what="the simulation")
        except LayflatError as error:
            return error

    def end(self) -> None:
        """End the processes for good."""
        self.beside.end()
        self._simulator.end()


def _share(newest: "SynchronizedArray[int]") -> None:
    _wanted["newest"] = newest


def _nothing() -> None:
    pass


def _cloud(tab: int, number: int, machine: Machine, step: Step, tolerances: Tolerances) -> Cloud | None:
    def overtaken() -> bool:
        return bool(_wanted["newest"][tab] > number)

    if overtaken():
        return None
    try:
        return cloud(machine, step, tolerances, overtaken=overtaken).rank()
    except OvertakenError:
        return None
