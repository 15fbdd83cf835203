"""Operator's page: the arm, its state, and the commands."""

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
from layflat.pages.look.pieces import REFRESH_PERIOD, Pieces, wait_for_browser
from layflat.pages.look.theme import finite_number
from layflat.pages.panel.charts_view import ChartsView
from layflat.pages.panel.check_view import CheckView, FailuresView
from layflat.pages.panel.controller_view import ControllerView
from layflat.pages.panel.desk import Controls, Desk
from layflat.pages.panel.drive_view import Jogs, JogView, Minder, OutputsView, TargetView
from layflat.pages.panel.logs_view import LogsView
from layflat.pages.panel.pilot import DEFAULT_SPEED_FRACTION, MOVABLE_STATES
from layflat.pages.panel.search import SEARCH_TIMEOUT, find_reachable
from layflat.pages.panel.sequence_view import SequenceView
from layflat.pages.panel.status_view import OperatorView, StatusView, TimingView

View = TypeVar("View")


async def panel_page(desk: Desk) -> None:
    """Build the page of a browser's tab within the present client, once its browser is there."""
    if await wait_for_browser():
        await PanelPage(desk).build()


class PanelPage:
    """Operator's page in one browser tab."""

    def __init__(self, desk: Desk) -> None:
        """Register the page as a visitor of the desk; `build` makes its elements."""
        self._desk = desk
        self._minder: Minder | None = None
        client = ui.context.client
        self._key = client.id
        self.controls = Controls(desk, self._key, DEFAULT_SPEED_FRACTION)
        self._name = desk.operators.register(self._key, self._drives_now).name
        client.on_delete(lambda: desk.operators.leave(self._key))
        self._seeks_reach, self._height = False, 0.0
        self._speeds: Callable[[Jogs], list[float]] | None = None  # of jogs, once they can be pressed

    async def build(self) -> None:
        """Build the page piece by piece, lease and stop button first, and keep it up to date."""
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
        await self._show_solids(pieces)

    async def _build_header(self, pieces: Pieces) -> None:
        """Build the header with stop button and operator; renew lease and header every `REFRESH_PERIOD` from now on."""
        desk, controls = self._desk, self.controls
        ui.add_css(files("layflat.pages.panel").joinpath("panel.css").read_text(encoding="utf-8"))
        with theme.frame("Panel", f"{desk.first.name} at {desk.rig.address}") as frame:
            await pieces.pause()
            with frame.buttons:
                self.stop = theme.button("Stop", controls.hold, icon="front_hand", kind="danger").classes("lf-stop")
            self._minder = Minder(self._renewed, controls.hold)
            with frame.status:
                self.operator = OperatorView(desk, self._key, self._name)
            self._columns = ui.element("div").classes("lf-desk")
        self._renew_and_refresh_header()
        ui.timer(REFRESH_PERIOD, self._renew_and_refresh_header)
        await pieces.pause()

    async def _build_left(self, pieces: Pieces) -> None:
        """Build the left column: the arm's scene, for arms in space the reach's height, and the charts."""
        desk = self._desk
        with theme.panel("Arm"):
            label = "The arm in three dimensions: as it is, and where it is to go"
            self.scene = ArmScene(desk.first, label=label, clicked=self._clicked)
            await pieces.pause()
            if desk.solids.hint:
                ui.label(desk.solids.hint).classes("lf-quiet lf-small")
            if desk.inverse.directions > 2:
                self._add_height()
        self.charts = ChartsView(desk)
        await pieces.pause()

    def _add_height(self) -> None:
        """Add the slider of the height (mm) at which the reachable surface is shown."""
        low, high = self._desk.extent[:, 2].tolist()
        with ui.row().classes("lf-line"):
            ui.label("Height of the green surface:").props('id="reach-height"')
            middle = round(500.0 * (low + high))
            self.height = ui.slider(min=round(1e3 * low), max=round(1e3 * high), step=10, value=middle)
            self.height.classes("lf-slider").props('aria-labelledby="reach-height"')
            ui.label().bind_text_from(self.height, "value", lambda x: f"{finite_number(x) or 0.0:.0f} mm")
            self.height.on("change", self._show_reach)

    async def _build_right(self, pieces: Pieces) -> None:
        """Build the right column: status, tabs of the commands, and timing; tab "Failures" for virtual rigs only."""
        desk, controls = self._desk, self.controls
        self.status = StatusView(desk, controls)
        with theme.panel("Move and look"):
            bar = ui.tabs().props("dense no-caps align=left outside-arrows mobile-arrows")
            with ui.tab_panels(bar, value="Jog", animated=False).classes("lf-plain"):
                self.jog, self.outputs = self._add_tab(bar, "Jog", lambda: (JogView(desk), OutputsView(desk, controls)))
                self._speeds = self.jog.speeds
                await pieces.pause()
                self.target = self._add_tab(bar, "Target", lambda: TargetView(desk, controls, lambda: self.scene))
                await pieces.pause()
                self.sequence = self._add_tab(bar, "Moves", lambda: SequenceView(desk, controls))
                await pieces.pause()
                self.check = self._add_tab(bar, "Check", lambda: CheckView(desk, controls))
                await pieces.pause()
                self.controller = self._add_tab(bar, "Controller", lambda: ControllerView(desk, controls))
                await pieces.pause()
                self.logs = self._add_tab(bar, "Logs", lambda: LogsView(desk))
                if (tell := desk.rig.send_line) is not None:
                    self._add_tab(bar, "Failures", lambda: FailuresView(tell, list(desk.first.joints)))
                await pieces.pause()
        self.timing = TimingView(desk)

    @staticmethod
    def _add_tab(bar: ui.tabs, name: str, build: Callable[[], View]) -> View:
        """Add a tab with its panel to the bar; return the view that `build` makes in the panel."""
        with bar:
            ui.tab(name)
        with ui.tab_panel(name).classes("lf-plain"):
            return build()

    async def _show_reach(self) -> None:
        """Compute the reachable surface at the slider's newest height in another process; show it unless that fails."""
        desk = self._desk
        self._height = 1e-3 * (finite_number(self.height.value) or 0.0) if desk.inverse.directions > 2 else 0.0
        if self._seeks_reach:
            return  # the search that runs ends with the newest height
        self._seeks_reach, shown = True, None
        what = "the search for what can be reached"
        try:
            while shown != self._height:
                shown = self._height
                call = partial(desk.worker.call, limit=SEARCH_TIMEOUT, what=what, by=self)
                surface = await call(find_reachable, desk.first, shown)
        except LayflatError:  # it is a help, without which the arm can be moved; a cancelled one is not begun again
            return
        finally:
            self._seeks_reach = False
        self.scene.show_reachable(*surface, on_floor=desk.inverse.directions < 3)

    async def _show_solids(self, pieces: Pieces) -> None:
        """Draw the arm by its solids once they are made and it rests: the browser is busy as it reads them."""
        if solids := await self._desk.solids.await_solids():
            await self._desk.solids.rest()
            await pieces.turn()
            for _ in self.scene.build_solids(solids):
                await pieces.pause()

    def _drives_now(self) -> None:
        """Send the page a beat, so that it renews the lease from the moment in which it drives."""
        if self._minder is not None:
            self._minder.beat(self._desk.operators.beat())

    def _renew_and_refresh_header(self) -> None:
        """Renew the lease if this page drives, and refresh the stop button and the operator."""
        desk = self._desk
        shot = desk.snapshot()
        if self.controls.drives:
            self._drives_now()
        self.stop.set_enabled(self.controls.drives and shot is not None and bool(shot["air"]))
        self.operator.refresh()

    def _refresh(self) -> None:
        """Refresh scene and views from the newest snapshot; only a page that drives a movable rig can move it."""
        desk = self._desk
        shot = desk.snapshot()
        drives = self.controls.drives
        can_move = drives and shot is not None and shot.state in MOVABLE_STATES
        if shot is not None and np.isfinite(shot["averaged_angle"]).all():
            self.scene.show_pose(shot["averaged_angle"])
        self.status.refresh(shot)
        self.timing.refresh(shot)
        self.charts.refresh()
        self.jog.refresh(shot, can_move)
        self.outputs.refresh(shot, drives)
        self.target.refresh(can_move)
        self.sequence.refresh(shot, can_move)
        self.check.refresh()
        self.controller.refresh()

    async def _clicked(self, place: Array) -> None:
        await self.target.clicked(place)

    def _renewed(self, beat: int, jogs: Jogs) -> None:
        """Renew the lease with a returned beat; if that succeeds, jog these joints and stop jogging the others."""
        if self._desk.operators.renew(self._key, beat) and self._speeds is not None:
            self.controls.jog(self._speeds(jogs))
