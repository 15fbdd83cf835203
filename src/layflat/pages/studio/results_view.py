"""The right side of the page: all results of a design, which follow its session."""

from collections.abc import Callable

from nicegui import ui

from layflat.errors import LayflatError
from layflat.pages.look.pieces import Pieces
from layflat.pages.studio.dialogs import Settings
from layflat.pages.studio.session import Session, What
from layflat.pages.studio.static_views import CamView, StrapView, TorqueView
from layflat.pages.studio.step_views import PressureView, StepView
from layflat.pages.studio.tables import FiguresView, FindingsView, Tiles, quantities


class ResultsView:
    """Pictures and figures, grey while they are older than the newest edit."""

    def __init__(self, session: Session, look_at: Callable[[str], object]) -> None:
        """Take what it shows; `look_at` is called with the joint that is chosen, `build` makes it."""
        self.session, self._look_at = session, look_at

    async def build(self, pieces: Pieces) -> None:
        """Make all views within the current element, piece by piece."""
        session, look_at = self.session, self._look_at
        joints = list(session.design.machine.joints)
        with ui.element("div").classes("st-bar-top"):
            if len(joints) > 1:
                ui.label("Joint").classes("st-name")
                chosen = ui.toggle(joints, value=session.step.joint, on_change=lambda event: look_at(event.value))
                chosen.props('dense no-caps unelevated toggle-color=primary aria-label="Joint that is shown"')
            Settings(session)
        await pieces.pause()
        self.tiles = Tiles()
        self.findings = FindingsView()
        await pieces.pause()
        with ui.element("div").classes("st-panels"):
            self.torque, self.step = TorqueView(session), StepView()
            await pieces.pause()
            self.cam, self.pressure = CamView(session), PressureView()
        await pieces.pause()
        self.strap, self.figures = StrapView(), FiguresView()
        await self.figures.build(pieces)

    def changed(self, what: What) -> None:
        """Follow a change of the session."""
        if what in {"figures", "kept"}:
            self._show_figures()
        if what in {"cloud", "kept"}:
            self._show_cloud()
        self._mark_current()

    def _mark_current(self) -> None:
        session, shown = self.session, self.session.shown
        statics, cloud = shown.figures_number == session.number, shown.cloud_number == session.number
        for view in (self.torque, self.cam, self.strap):
            view.current(statics)
        for late in (self.step, self.pressure):
            late.current(cloud)
        self.tiles.current(statics and cloud)
        self.figures.current(statics and cloud)

    def _show_figures(self) -> None:
        session = self.session
        figures, kept = session.shown.figures, session.kept.shown.figures if session.kept else None
        if figures is not None:
            kept = kept if kept is not None and kept.joint == figures.joint else None
            self.torque.show(figures, kept)
            self.cam.show(figures, kept)
            self.strap.show(figures)
        self.findings.show(session.findings, session.design.machine.origin, known=figures is not None)
        self._show_tables()

    def _show_cloud(self) -> None:
        shown, kept = self.session.shown, self.session.kept
        if shown.cloud is not None:
            other = kept.shown.cloud if kept is not None else None
            for view in (self.step, self.pressure):
                view.show(shown.cloud, other if not isinstance(other, LayflatError) else None)
        self._show_tables()

    def _show_tables(self) -> None:
        now, other = quantities(self.session)
        self.tiles.show(now, other)
        self.figures.show(now, other)
