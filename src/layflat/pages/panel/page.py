"""The operator's page: the arm, its state, and what may be done with it."""

from collections.abc import Callable
from importlib.resources import files
from typing import TypeVar

import numpy as np
from nicegui import run, ui
from nicegui.client import Client

from layflat.arrays import Array
from layflat.pages.look import theme
from layflat.pages.look.arm_scene import ArmScene
from layflat.pages.panel.charts_view import ChartsView
from layflat.pages.panel.check_view import CheckView
from layflat.pages.panel.controller_view import ControllerView
from layflat.pages.panel.desk import Desk
from layflat.pages.panel.drive_view import JogView, OutputsView, TargetView
from layflat.pages.panel.failures_view import FailuresView
from layflat.pages.panel.logs_view import LogsView
from layflat.pages.panel.minder import Jogs, Minder
from layflat.pages.panel.pilot import MOVES
from layflat.pages.panel.reach import reachable
from layflat.pages.panel.sequence_view import SequenceView
from layflat.pages.panel.status_view import OperatorView, StatusView, TimingView

View = TypeVar("View")

EVERY = 0.1  # between two pictures of what is so, s


class PanelPage:
    """The page of one browser's tab."""

    def __init__(self, desk: Desk) -> None:
        """Build it within the present client."""
        self._desk = desk
        client = ui.context.client
        self._key = client.id
        visitor = desk.operators.come(self._key)
        client.on_delete(lambda: desk.operators.leave(self._key))
        ui.add_css(files("layflat.pages.panel").joinpath("panel.css").read_text(encoding="utf-8"))
        with theme.frame("Panel", f"{desk.first.name} at {desk.rig.address}") as frame:
            with frame.status:
                self.operator = OperatorView(desk, self._key, visitor.name)
            with frame.buttons:
                self.stop = theme.button("Stop", self._stop, icon="front_hand", kind="danger").classes("lf-stop")
            self.minder = Minder(self._renewed, self._stop)
            with ui.element("div").classes("lf-desk"):
                with ui.element("div").classes("lf-side"):
                    self._build_left()
                with ui.element("div").classes("lf-side"):
                    self._build_right()
        self._beats(client)

    def _build_left(self) -> None:
        desk = self._desk
        with theme.panel("Arm"):
            label = "The arm in three dimensions: as it is, and where it is to go"
            self.scene = ArmScene(desk.first, label=label, clicked=self._clicked)
            if desk.inverse.directions > 2:
                self._add_height()
        self.charts = ChartsView(desk)

    def _add_height(self) -> None:
        low, high = self._desk.inverse.tips[:, 2].min(), self._desk.inverse.tips[:, 2].max()
        with ui.row().classes("lf-line"):
            ui.label("Height of the green surface:").props('id="reach-height"')
            middle = round(500.0 * (low + high))
            self.height = ui.slider(min=round(1e3 * low), max=round(1e3 * high), step=10, value=middle)
            self.height.classes("lf-slider").props('aria-labelledby="reach-height"')
            ui.label().bind_text_from(self.height, "value", lambda x: f"{x:.0f} mm")
            self.height.on("change", self._show_reach)

    def _build_right(self) -> None:
        desk = self._desk
        self.status = StatusView(desk, self._key)
        with theme.panel("Move and look"):
            bar = ui.tabs().props("dense no-caps align=left outside-arrows mobile-arrows")
            with ui.tab_panels(bar, value="Jog", animated=False).classes("lf-plain"):
                self.jog, self.outputs = self._tab(bar, "Jog", lambda: (JogView(desk), OutputsView(desk)))
                self.target = self._tab(bar, "Target", lambda: TargetView(desk, lambda: self.scene))
                self.sequence = self._tab(bar, "Moves", lambda: SequenceView(desk))
                self.check = self._tab(bar, "Check", lambda: CheckView(desk, self._key))
                self.controller = self._tab(bar, "Controller", lambda: ControllerView(desk, self._key))
                self._tab(bar, "Logs", lambda: LogsView(desk))
                if (tell := desk.rig.tell) is not None:
                    self._tab(bar, "Failures", lambda: FailuresView(tell, list(desk.first.joints)))
        self.timing = TimingView(desk)

    @staticmethod
    def _tab(bar: ui.tabs, name: str, build: Callable[[], View]) -> View:
        with bar:
            ui.tab(name)
        with ui.tab_panel(name).classes("lf-plain"):
            return build()

    def _beats(self, client: Client) -> None:
        async def begin() -> None:
            await client.connected()
            await self._show_reach()

        ui.timer(EVERY, self._refresh)
        ui.timer(0.0, begin, once=True)

    async def _show_reach(self) -> None:
        height = 1e-3 * float(self.height.value) if self._desk.inverse.directions > 2 else 0.0
        found = await run.io_bound(reachable, self._desk.inverse, height)
        if found is not None:  # the page is still there
            self.scene.reachable(*found, on_floor=self._desk.inverse.directions < 3)

    def _refresh(self) -> None:
        desk = self._desk
        shot = desk.snapshot()
        self.minder.beat(desk.operators.beat())
        drives = desk.operators.drives(self._key)
        fits = drives and shot is not None and shot.state in MOVES
        if shot is not None and np.isfinite(shot["averaged_angle"]).all():
            self.scene.pose(shot["averaged_angle"])
        self.stop.set_enabled(drives and shot is not None and bool(shot["air"]))
        self.operator.refresh()
        self.status.refresh(shot)
        self.timing.refresh(shot)
        self.charts.refresh()
        self.jog.refresh(shot, fits)
        self.outputs.refresh(shot, drives)
        self.target.refresh(fits)
        self.sequence.refresh(shot, fits)
        self.check.refresh()
        self.controller.refresh()

    def _clicked(self, place: Array) -> None:
        self.target.clicked(place)

    def _renewed(self, beat: int, jogs: Jogs) -> None:
        if self._desk.operators.renew(self._key, beat):
            self._desk.pilot.jog(self.jog.speeds(jogs))

    def _stop(self) -> None:
        if self._desk.operators.drives(self._key):
            self._desk.pilot.stop()
