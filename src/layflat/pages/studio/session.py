"""One tab's work: its design, what is looked at, and results that follow the newest edit without anybody waiting."""

import asyncio
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeVar

from layflat.design.findings import ORDER, Finding
from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.pages.studio.beside import LIMIT, find_figures, find_stale
from layflat.pages.studio.cloud import Cloud, Step, Tolerances, usual_step
from layflat.pages.studio.design import Changes, Design
from layflat.pages.studio.results import Figures
from layflat.pages.studio.worker import Worker

Result = TypeVar("Result")
What = Literal["design", "figures", "cloud", "kept"]
"""What has changed: what is asked for; the statics; the cloud; the design that is kept as A."""

QUICK = 0.2  # a cloud that takes less is let finish when a newer design comes, so that a drag shows something, s


@dataclass
class Shown:
    """Results, and the number of the request that they belong to."""

    figures: Figures | None = None
    cloud: Cloud | LayflatError | None = None
    figures_number: int = 0
    cloud_number: int = 0


@dataclass
class Kept:
    """A design that others are compared with, "A"."""

    machine: Machine
    changes: Changes
    since: str  # when it was kept, for people
    shown: Shown = field(default_factory=Shown)


class Session:
    """State of a tab. Results come by `follow`, which runs as long as the tab is open."""

    def __init__(self, design: Design, worker: Worker) -> None:
        self.design = design
        self.step = usual_step(design.machine)
        self.tolerances = Tolerances()
        self.kept: Kept | None = None
        self.shown = Shown()
        self.stale: list[Finding] = []
        self.number = 1  # of the newest request
        self.waiting_since: float | None = None  # for a cloud, by the monotonic clock
        self.worker, self._tab = worker, worker.tab()
        self._requests = 0
        self._listeners: list[Callable[[What], object]] = []
        self._wanted = asyncio.Event(), asyncio.Event()

    def listen(self, listener: Callable[[What], object]) -> None:
        """Call a function whenever something changes, with what it is."""
        self._listeners.append(listener)

    def leave(self) -> None:
        """Call nobody any more: the page was closed, and may come back."""
        self._listeners.clear()

    def look(self, step: Step | None = None, tolerances: Tolerances | None = None) -> None:
        """Look at another step, or with other tolerances."""
        self.step, self.tolerances = step or self.step, tolerances or self.tolerances
        if self.kept is not None:
            self.kept.shown = Shown()
        self.renew()

    def look_at(self, joint: str) -> None:
        """Look at another joint."""
        if joint != self.step.joint:
            self.shown = Shown()
            self.look(replace(self.step, joint=joint))

    def keep(self) -> None:
        """Keep the design as A, with its results as far as they are there."""
        shown = Shown()
        if self.shown.figures_number == self.number:
            shown.figures = self.shown.figures
        if self.shown.cloud_number == self.number:
            shown.cloud = self.shown.cloud
        self.kept = Kept(self.design.machine, self.design.changes, time.strftime("%H:%M"), shown)
        self.renew()
        self._tell("kept")

    def drop(self) -> None:
        """Forget A."""
        self.kept = None
        self._tell("kept")

    def renew(self) -> None:
        """Ask for new results: the design has changed, or what is looked at."""
        self.number += 1
        if isinstance(self.shown.cloud, Cloud) and self.shown.cloud.seconds > QUICK:
            self.worker.overtake(self._tab, self._requests + 1)
        for wanted in self._wanted:
            wanted.set()
        self._tell("design")

    @property
    def findings(self) -> list[Finding]:
        """Findings of the design rules and checks, worst first."""
        found = [*(self.shown.figures.findings if self.shown.figures else ()), *self.stale]
        return sorted(found, key=lambda finding: ORDER.index(finding.severity))

    async def follow(self) -> None:
        """Bring results for the newest request, again and again."""
        for wanted in self._wanted:
            wanted.set()
        async with asyncio.TaskGroup() as group:
            group.create_task(self._again(self._wanted[0], self._bring_figures))
            group.create_task(self._again(self._wanted[1], self._bring_cloud))

    async def _again(self, wanted: asyncio.Event, bring: Callable[[int], Awaitable[None]]) -> None:
        while True:
            await wanted.wait()
            wanted.clear()
            try:
                await bring(self.number)
            except asyncio.CancelledError:  # another page of this session may have been overtaken by what ends here
                wanted.set()
                raise
            except Exception as error:  # a law or a library failed: the person goes on, and knows
                what = f"results can't be computed ({type(error).__name__}: {error})"
                self.stale = [Finding("error", "results", self.design.machine.origin, what, "undo the last edit")]
                self._tell("figures")

    async def _bring_figures(self, number: int) -> None:
        design, joint = self.design, self.step.joint
        figures = await self._beside(find_figures, self._tab, False, design.machine, joint)
        self.shown.figures, self.shown.figures_number = figures, number
        self._tell("figures")
        kept = self.kept
        if kept is not None and (kept.shown.figures is None or kept.shown.figures.joint != joint):
            kept.shown.figures = await self._beside(find_figures, self._tab, True, kept.machine, joint)
            self._tell("kept")
        if number == self.number:
            found = await self._beside(find_stale, design)
            if number == self.number and found != self.stale:
                self.stale = found
                self._tell("figures")

    async def _beside(self, work: Callable[..., Result], *arguments: Any) -> Result:
        return await self.worker.beside.call(work, *arguments, limit=LIMIT, what="the design of a joint")

    async def _bring_cloud(self, number: int) -> None:
        self.waiting_since = time.monotonic()
        found = await self._cloud(self.design.machine)
        if found is None:
            return
        self.shown.cloud, self.shown.cloud_number, self.waiting_since = found, number, None
        self._tell("cloud")
        kept = self.kept
        if kept is not None and not (isinstance(kept.shown.cloud, Cloud) and kept.shown.cloud.step == self.step):
            kept.shown.cloud = await self._cloud(kept.machine)
            self._tell("kept")

    async def _cloud(self, machine: Machine) -> Cloud | LayflatError | None:
        self._requests += 1
        return await self.worker.cloud(self._tab, self._requests, machine, self.step, self.tolerances)

    def _tell(self, what: What) -> None:
        for listener in self._listeners:
            listener(what)
