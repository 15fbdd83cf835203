"""Session of one tab: its design, the step that is simulated, and results that follow the newest edit."""

import asyncio
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

from layflat.design.summary import SEVERITY_ORDER, Finding
from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.pages.studio.cloud import JointStep, StepCloud, Tolerances, default_step
from layflat.pages.studio.design import Changes, Design
from layflat.pages.studio.results import JointFigures
from layflat.pages.studio.worker import StudioProcesses, find_figures, find_stale, reread, write_design
from layflat.solids.moving import MovingSolids

Result = TypeVar("Result")
ChangedPart = Literal["design", "figures", "cloud", "kept", "solids"]
"""Changed part of a session: the design or step; the statics; the cloud; the design kept as A; the solids."""

QUICK_CLOUD_TIME = (
    0.2  # of a cloud that is finished in spite of a newer design, so that dragging a slider shows results, s
)


@dataclass
class ShownResults:
    """Results, and the numbers of the requests that they belong to."""

    figures: JointFigures | None = None
    cloud: StepCloud | LayflatError | None = None
    figures_number: int = 0
    cloud_number: int = 0


@dataclass
class KeptDesign:
    """Design "A" that others are compared with."""

    machine: Machine
    changes: Changes
    since: str  # time of day at which it was kept, as text
    shown: ShownResults = field(default_factory=ShownResults)


class StudioSession:
    """Session of a tab; `follow` computes its results as long as the tab is open."""

    def __init__(self, design: Design, worker: StudioProcesses) -> None:
        """Begin with the default step and tolerances; nothing is computed before `follow`."""
        self.design = design
        self.step = default_step(design.machine)
        self.tolerances = Tolerances()
        self.kept: KeptDesign | None = None
        self.shown = ShownResults()
        self.stale: list[Finding] = []
        self.solids: tuple[Machine, list[MovingSolids]] | None = None  # of the newest design whose solids are made
        self.solids_number = 0  # of the request that they belong to
        self.number = 1  # of the newest request
        self.waiting_since: float | None = None  # start of the wait for a cloud, s, monotonic
        self.worker, self._tab = worker, worker.tab()
        self._requests = 0
        self._listeners: list[Callable[[ChangedPart], object]] = []
        self._requested = asyncio.Event(), asyncio.Event(), asyncio.Event()

    def listen(self, listener: Callable[[ChangedPart], object]) -> None:
        """Call a function with the changed part after every change."""
        self._listeners.append(listener)

    def leave(self) -> None:
        """Remove all listeners: the page was closed; another page may show the session later."""
        self._listeners.clear()

    def simulate(self, step: JointStep | None = None, tolerances: Tolerances | None = None) -> None:
        """Request the simulation of another step, or with other tolerances, and drop the results of A.

        None keeps the present step or tolerances.
        """
        self.step, self.tolerances = step or self.step, tolerances or self.tolerances
        if self.kept is not None:
            self.kept.shown = ShownResults()
        self.renew()

    def show_joint(self, joint: str) -> None:
        """Clear the results and request those of another joint; nothing for the joint that is shown."""
        if joint != self.step.joint:
            self.shown = ShownResults()
            self.simulate(replace(self.step, joint=joint))

    def keep_as_a(self) -> None:
        """Keep the design as A, in place of an earlier A, with its results if they are up to date; request new ones."""
        shown = ShownResults()
        if self.shown.figures_number == self.number:
            shown.figures = self.shown.figures
        if self.shown.cloud_number == self.number:
            shown.cloud = self.shown.cloud
        self.kept = KeptDesign(self.design.machine, self.design.changes, time.strftime("%H:%M"), shown)
        self.renew()
        self._notify("kept")

    def drop(self) -> None:
        """Drop A."""
        self.kept = None
        self._notify("kept")

    def renew(self) -> None:
        """Request new results: the design, the step or the tolerances have changed.

        A simulation that runs is ended if the last one took longer than `QUICK_CLOUD_TIME`.
        """
        self.number += 1
        if isinstance(self.shown.cloud, StepCloud) and self.shown.cloud.seconds > QUICK_CLOUD_TIME:
            self.worker.overtake(self._tab, self._requests + 1)
        for requested in self._requested:
            requested.set()
        self._notify("design")

    async def reload(self) -> list[str]:
        """Read the description again and overlay all changes, also those made during the reading.

        Returns:
            Paths of changes that are refused now and were dropped.

        Raises:
            InputError: the description can't be read; nothing changes.
        """
        while True:
            changes = self.design.changes
            design, dropped = await self.worker.perform(reread, self.design, what="the reading of the file")
            if self.design.changes is changes:
                self.design.become(design)
                return dropped

    async def save(self, path: Path) -> None:
        """Write the design as a description in another process, without changes made meanwhile.

        Raises:
            LayflatError: one of `saving.save`, or the process took too long or has ended.
        """
        opened = self.design.opened
        saved = await self.worker.perform(write_design, self.design, path, what="the saving")
        if self.design.opened is opened:
            self.design.opened = saved

    @property
    def findings(self) -> list[Finding]:
        """Findings of the design rules and checks, worst first."""
        findings = [*(self.shown.figures.findings if self.shown.figures else ()), *self.stale]
        return sorted(findings, key=lambda finding: SEVERITY_ORDER.index(finding.severity))

    async def follow(self) -> None:
        """Compute results at once, and again after each request, until cancelled.

        Figures, cloud and solids are computed concurrently. Of the requests during a computation only the newest is
        answered. An unexpected error becomes a finding.
        """
        for requested in self._requested:
            requested.set()
        async with asyncio.TaskGroup() as group:
            group.create_task(self._repeat_update(self._requested[0], self._update_figures))
            group.create_task(self._repeat_update(self._requested[1], self._update_cloud))
            group.create_task(self._repeat_update(self._requested[2], self._update_solids))

    async def _repeat_update(self, requested: asyncio.Event, update: Callable[[int], Awaitable[None]]) -> None:
        """Update results after each request, until cancelled; an unexpected error becomes a finding on the page."""
        while True:
            await requested.wait()
            requested.clear()
            try:
                await update(self.number)
            except (
                asyncio.CancelledError
            ):  # the work that ends here may have replaced that of another page of this session
                requested.set()
                raise
            except Exception as error:  # a law or a library failed: the person is informed and continues
                what = f"results can't be computed ({type(error).__name__}: {error})"
                self.stale = [Finding("error", "results", self.design.machine.origin, what, "undo the last edit")]
                self._notify("figures")

    async def _update_figures(self, number: int) -> None:
        """Compute the figures of the joint and of design A, then the outdated values if the design is the newest."""
        design, joint = self.design, self.step.joint
        figures = await self._design_in_process(find_figures, self._tab, False, design.machine, joint)
        self.shown.figures, self.shown.figures_number = figures, number
        self._notify("figures")
        kept = self.kept
        if kept is not None and (kept.shown.figures is None or kept.shown.figures.joint != joint):
            kept.shown.figures = await self._design_in_process(find_figures, self._tab, True, kept.machine, joint)
            self._notify("kept")
        if number == self.number:
            stale = await self._design_in_process(find_stale, design)
            if number == self.number and stale != self.stale:
                self.stale = stale
                self._notify("figures")

    async def _update_solids(self, number: int) -> None:
        """Make the solids of the design."""
        machine = self.design.machine
        if self.solids is None or self.solids[0] != machine:
            self.solids = machine, await self.worker.solids(machine)
        self.solids_number = number
        self._notify("solids")

    async def _design_in_process(self, work: Callable[..., Result], *arguments: Any) -> Result:
        return await self.worker.perform(work, *arguments, what="the design of a joint")

    async def _update_cloud(self, number: int) -> None:
        """Simulate the cloud of the design, then of A if it has none of this step.

        An overtaken cloud of the design changes nothing, and the wait goes on; one of A leaves A without.
        """
        self.waiting_since = time.monotonic()
        cloud = await self._cloud(self.design.machine)
        if cloud is None:
            return
        self.shown.cloud, self.shown.cloud_number, self.waiting_since = cloud, number, None
        self._notify("cloud")
        kept = self.kept
        if kept is not None and not (isinstance(kept.shown.cloud, StepCloud) and kept.shown.cloud.step == self.step):
            kept.shown.cloud = await self._cloud(kept.machine)
            self._notify("kept")

    async def _cloud(self, machine: Machine) -> StepCloud | LayflatError | None:
        """Return the cloud of a machine for the present step and tolerances, its error, or None if overtaken."""
        self._requests += 1
        return await self.worker.cloud(self._tab, self._requests, machine, self.step, self.tolerances)

    def _notify(self, what: ChangedPart) -> None:
        for listener in self._listeners:
            listener(what)
