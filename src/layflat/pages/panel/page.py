"""The operator's page: the arm, its state, and what may be done with it."""

from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import TypeVar

import numpy as np
from nicegui import ui

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.arm_scene import ArmScene
from layflat.pages.look.dialogs import number
from layflat.pages.look.pieces import Pieces, arrived
from layflat.pages.look.rounds import EVERY
from layflat.pages.panel.charts_view import ChartsView
from layflat.pages.panel.check_view import CheckView
from layflat.pages.panel.controller_view import ControllerView
from layflat.pages.panel.controls import Controls
from layflat.pages.panel.desk import Desk
from layflat.pages.panel.drive_view import JogView, OutputsView, TargetView
from layflat.pages.panel.failures_view import FailuresView
from layflat.pages.panel.logs_view import LogsView
from layflat.pages.panel.minder import Jogs, Minder
from layflat.pages.panel.pilot import MOVES, USUAL_SHARE
from layflat.pages.panel.search import LONGEST_SEARCH, find_reachable
from layflat.pages.panel.sequence_view import SequenceView
from layflat.pages.panel.status_view import OperatorView, StatusView, TimingView

View = TypeVar("View")


async def panel_page(desk: Desk) -> None:
    """Build the page of a browser's tab within the present client, once its browser is there."""
    if await arrived():
        await PanelPage(desk).build()


class PanelPage:
    """The page of one browser's tab."""

    def __init__(self, desk: Desk) -> None:
        """Take what all pages share; `build` makes what is seen."""
        self._desk = desk
        self._minder: Minder | None = None
        client = ui.context.client
        self._key = client.id
        self.controls = Controls(desk, self._key, USUAL_SHARE)
        self._name = desk.operators.come(self._key, self._drives_now).name
        client.on_delete(lambda: desk.operators.leave(self._key))
        self._seeks_reach, self._height = False, 0.0
        self._speeds: Callable[[Jogs], list[float]] | None = None  # of jogs, once they can be pressed

    async def build(self) -> None:
        """Build the page piece by piece, at first what minds the rig and stops it, and keep it up to date."""
        pieces = Pieces()
        await self._build_header(pieces)
        with self._columns:
            with ui.element("div").classes("lf-side"):
                await self._build_left(pieces)
            with ui.element("div").classes("lf-side"):
                await self._build_right(pieces)
        desk, key = self._desk, self._key
        ui.context.client.on_delete(lambda: desk.rounds.remove(key))
        ui.context.client.on_delete(lambda: desk.worker.forget(self))
        desk.rounds.add(key, self._refresh)
        await self._show_reach()
        await self.logs.list_logs()
        await self.sequence.list_saved()

    async def _build_header(self, pieces: Pieces) -> None:
        desk, controls = self._desk, self.controls
        ui.add_css(files("layflat.pages.panel").joinpath("panel.css").read_text(encoding="utf-8"))
        with theme.frame("Panel", f"{desk.first.name} at {desk.rig.address}") as frame:
            await pieces.pause()
            with frame.buttons:
                self.stop = theme.button("Stop", controls.stop, icon="front_hand", kind="danger").classes("lf-stop")
            self._minder = Minder(self._renewed, controls.stop)
            with frame.status:
                self.operator = OperatorView(desk, self._key, self._name)
            self._columns = ui.element("div").classes("lf-desk")
        self._beat()
        ui.timer(EVERY, self._beat)
        await pieces.pause()

    async def _build_left(self, pieces: Pieces) -> None:
        desk = self._desk
        with theme.panel("Arm"):
            label = "The arm in three dimensions: as it is, and where it is to go"
            self.scene = ArmScene(desk.first, label=label, clicked=self._clicked)
            await pieces.pause()
            if desk.inverse.directions > 2:
                self._add_height()
        self.charts = ChartsView(desk)
        await pieces.pause()

    def _add_height(self) -> None:
        low, high = self._desk.extent[:, 2].tolist()
        with ui.row().classes("lf-line"):
            ui.label("Height of the green surface:").props('id="reach-height"')
            middle = round(500.0 * (low + high))
            self.height = ui.slider(min=round(1e3 * low), max=round(1e3 * high), step=10, value=middle)
            self.height.classes("lf-slider").props('aria-labelledby="reach-height"')
            ui.label().bind_text_from(self.height, "value", lambda x: f"{number(x) or 0.0:.0f} mm")
            self.height.on("change", self._show_reach)

    async def _build_right(self, pieces: Pieces) -> None:
        desk, controls = self._desk, self.controls
        self.status = StatusView(desk, controls)
        with theme.panel("Move and look"):
            bar = ui.tabs().props("dense no-caps align=left outside-arrows mobile-arrows")
            with ui.tab_panels(bar, value="Jog", animated=False).classes("lf-plain"):
                self.jog, self.outputs = self._tab(bar, "Jog", lambda: (JogView(desk), OutputsView(desk, controls)))
                self._speeds = self.jog.speeds
                await pieces.pause()
                self.target = self._tab(bar, "Target", lambda: TargetView(desk, controls, lambda: self.scene))
                await pieces.pause()
                self.sequence = self._tab(bar, "Moves", lambda: SequenceView(desk, controls))
                await pieces.pause()
                self.check = self._tab(bar, "Check", lambda: CheckView(desk, controls))
                await pieces.pause()
                self.controller = self._tab(bar, "Controller", lambda: ControllerView(desk, controls))
                await pieces.pause()
                self.logs = self._tab(bar, "Logs", lambda: LogsView(desk))
                if (tell := desk.rig.tell) is not None:
                    self._tab(bar, "Failures", lambda: FailuresView(tell, list(desk.first.joints)))
                await pieces.pause()
        self.timing = TimingView(desk)

    @staticmethod
    def _tab(bar: ui.tabs, name: str, build: Callable[[], View]) -> View:
        with bar:
            ui.tab(name)
        with ui.tab_panel(name).classes("lf-plain"):
            return build()

    async def _show_reach(self) -> None:
        desk = self._desk
        self._height = 1e-3 * (number(self.height.value) or 0.0) if desk.inverse.directions > 2 else 0.0
        if self._seeks_reach:
            return  # what is shown in the end is the newest height
        self._seeks_reach, shown = True, None
        what = "the search for what can be reached"
        try:
            while shown != self._height:
                shown = self._height
                call = partial(desk.worker.call, limit=LONGEST_SEARCH, what=what, by=self)
                found = await call(find_reachable, desk.first, shown)
        except LayflatError:  # it is a help, without which the arm can be moved; a cancelled one is not begun again
            return
        finally:
            self._seeks_reach = False
        self.scene.reachable(*found, on_floor=desk.inverse.directions < 3)

    def _drives_now(self) -> None:
        """Make the page renew the lease from the moment on in which it drives."""
        if self._minder is not None:
            self._minder.beat(self._desk.operators.beat())

    def _beat(self) -> None:
        desk = self._desk
        shot = desk.snapshot()
        if self.controls.drives:
            self._drives_now()
        self.stop.set_enabled(self.controls.drives and shot is not None and bool(shot["air"]))
        self.operator.refresh()

    def _refresh(self) -> None:
        desk = self._desk
        shot = desk.snapshot()
        drives = self.controls.drives
        fits = drives and shot is not None and shot.state in MOVES
        if shot is not None and np.isfinite(shot["averaged_angle"]).all():
            self.scene.pose(shot["averaged_angle"])
        self.status.refresh(shot)
        self.timing.refresh(shot)
        self.charts.refresh()
        self.jog.refresh(shot, fits)
        self.outputs.refresh(shot, drives)
        self.target.refresh(fits)
        self.sequence.refresh(shot, fits)
        self.check.refresh()
        self.controller.refresh()

    async def _clicked(self, place: Array) -> None:
        await self.target.clicked(place)

    def _renewed(self, beat: int, jogs: Jogs) -> None:
        if self._desk.operators.renew(self._key, beat) and self._speeds is not None:
            self.controls.jog(self._speeds(jogs))
