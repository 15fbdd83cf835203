"""Processes that work for all tabs of the studio; of each tab only the newest design is simulated to its end.

They run calls that take longer than the event loop may be held up.
"""

from collections import OrderedDict
from collections.abc import Callable
from itertools import count
from multiprocessing import get_context
from multiprocessing.sharedctypes import SynchronizedArray
from pathlib import Path
from typing import Any, TypeVar

from layflat.design.summary import Finding
from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.pages.server.worker import ProcessWorker
from layflat.pages.studio.cloud import JointStep, OvertakenError, StepCloud, Tolerances, simulate_cloud
from layflat.pages.studio.design import Design, OpenedDescription, open_description
from layflat.pages.studio.results import Designer, JointFigures
from layflat.pages.studio.saving import list_stale, save
from layflat.solids.moving import MovingSolids, moving_solids

Result = TypeVar("Result")
CALL_TIMEOUT = 60.0  # time of one call, s
SOLIDS_TIMEOUT = 120.0  # time of making an arm's solids, s
MAX_DESIGNERS = 16  # designs whose joints are cached
_designers: OrderedDict[tuple[int, bool], Designer] = OrderedDict()
MAX_TABS = 256  # with a number of their own; more share numbers, and may overtake each other
CLOUD_TIMEOUT = 600.0  # time of a simulation, the compiling of its kernel included, s
_wanted: dict[str, Any] = {}
"""In the process that simulates: number of the newest request of each tab."""


def open_design(machine: str) -> Design:
    """Return the design of a built-in machine or a file, with its fields computed; raise MachineError as `load`."""
    design = Design(open_description(machine))
    _ = design.fields
    return design


def find_figures(tab: int, kept: bool, machine: Machine, joint: str) -> JointFigures:
    """Return the statics of a joint, its curves computed as well; unchanged joints of the tab come from a cache.

    Args:
        tab: number of the tab: its joints that have not changed are not redesigned.
        kept: whether the design is kept as A by the tab: these have a cache of their own.
        machine: machine of the design.
        joint: name of the joint.
    """
    designer = _designers.setdefault((tab, kept), Designer())
    _designers.move_to_end((tab, kept))
    while len(_designers) > MAX_DESIGNERS:
        _designers.popitem(last=False)
    figures = designer.figures(machine, joint)
    _ = figures.quantities, figures.torque, figures.roller_torque  # found here, not where they are shown
    return figures


def find_stale(design: Design) -> list[Finding]:
    """Return the findings of `list_stale`; none where the design can't be loaded."""
    try:
        return list_stale(design)
    except LayflatError:  # its base is missing or broken by now, which other checks report
        return []


def write_design(design: Design, path: Path) -> OpenedDescription:
    """Write a design by `save`, whose errors it raises, and return the design's opened description afterwards."""
    save(design, path)
    return design.opened


def reread(design: Design) -> tuple[Design, list[str]]:
    """Read a design's description again; return the design, and the paths of dropped changes, see `Design.reload`."""
    dropped = design.reload()
    return design, dropped


class StudioProcesses:
    """Processes, started with the first request and again if they end.

    One simulates, one makes solids, one does all else.
    """

    def __init__(self) -> None:
        """Prepare the processes, which start with their first calls."""
        self.helper = ProcessWorker("layflat-studio")  # for work that is shorter than a cloud and must not wait for it
        self._newest: SynchronizedArray[int] = get_context("spawn").Array("Q", MAX_TABS)
        self._builder = ProcessWorker("layflat-studio-solids")
        self._simulator = ProcessWorker("layflat-studio-runs", first=_set_newest, shared=(self._newest,))
        self._tabs = count()

    def start_simulator(self) -> None:
        """Begin to start the process that simulates, so that it is ready when it is needed; return at once."""
        self._simulator.warm_up(int)

    def tab(self) -> int:
        """Return the next number for a tab, 0 to `MAX_TABS` - 1, after which numbers repeat."""
        return next(self._tabs) % MAX_TABS

    async def perform(self, work: Callable[..., Result], *arguments: Any, what: str) -> Result:
        """Call a function that takes less than a cloud, and return its result; raises as `ProcessWorker.call`."""
        return await self.helper.call(work, *arguments, limit=CALL_TIMEOUT, what=what)

    async def solids(self, machine: Machine) -> list[MovingSolids]:
        """Return the solids of a machine's arm; none where they can't be made."""
        try:
            return await self._builder.call(moving_solids, machine, limit=SOLIDS_TIMEOUT, what="the making of solids")
        except LayflatError:
            return []

    def overtake(self, tab: int, number: int) -> None:
        """End the simulations of a tab whose requests have a lower number, without a result."""
        self._newest[tab] = number

    async def cloud(
        self, tab: int, number: int, machine: Machine, step: JointStep, tolerances: Tolerances
    ) -> StepCloud | LayflatError | None:
        """Return the cloud of a machine; the error that ended it; or None where it was overtaken.

        Args:
            tab: number of the tab.
            number: number of the request, growing in a tab.
            machine: nominal machine.
            step: step of a joint.
            tolerances: ranges of the values that vary.
        """
        self.overtake(tab, number)
        arguments = tab, number, machine, step, tolerances
        try:
            return await self._simulator.call(_simulate_newest, *arguments, limit=CLOUD_TIMEOUT, what="the simulation")
        except LayflatError as error:
            return error

    def end(self) -> None:
        """End the processes."""
        self.helper.end()
        self._builder.end()
        self._simulator.end()


def _set_newest(newest: "SynchronizedArray[int]") -> None:
    _wanted["newest"] = newest


def _simulate_newest(
    tab: int, number: int, machine: Machine, step: JointStep, tolerances: Tolerances
) -> StepCloud | None:
    """Return the cloud of a step, ranked, or None if a newer request of the same tab has overtaken it."""

    def overtaken() -> bool:
        return bool(_wanted["newest"][tab] > number)

    if overtaken():
        return None
    try:
        return simulate_cloud(machine, step, tolerances, overtaken=overtaken).rank()
    except OvertakenError:
        return None
