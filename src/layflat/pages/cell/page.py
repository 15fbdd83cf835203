"""The page of a run: what the cell does, what it sees, what came of it, and a button that ends it."""

from importlib.resources import files

from nicegui import ui

from layflat.pages.cell.desk import Desk
from layflat.pages.cell.images_view import ImagesView
from layflat.pages.cell.picks_view import FiguresView, PicksView
from layflat.pages.cell.snapshot import Snapshot, Stage
from layflat.pages.cell.state_view import EndView, NowView, pace_words
from layflat.pages.look import theme
from layflat.pages.look.dialogs import confirmed
from layflat.pages.look.pieces import Pieces, arrived

QUESTION = "End the run? What was done so far is kept, and its results are marked as partial."


async def run_page(desk: Desk) -> None:
    """Build the page of a browser's tab within the present client, once its browser is there."""
    if await arrived():
        await RunPage(desk).build()


class RunPage:
    """The page of one browser's tab."""

    def __init__(self, desk: Desk) -> None:
        """Take what it shows; `build` shows it."""
        self._desk = desk
        self._shown: Snapshot | None = None

    async def build(self) -> None:
        """Build it within the present client, piece by piece, and keep it up to date."""
        desk, about, pieces, client = self._desk, self._desk.about, Pieces(), ui.context.client
        ui.add_css(files("layflat.pages.cell").joinpath("cell.css").read_text(encoding="utf-8"))
        with theme.frame("Packing cell", f"{about.cell} with {about.machine}, seed {about.seed}") as frame:
            with frame.status:
                self.status = ui.label().props("id=cell-status")
            with frame.buttons:
                self.stop = theme.button("Stop", self._stop, icon="front_hand", kind="danger")
                self.stop.classes("ce-stop").props("id=cell-stop")
            await pieces.pause()
            self.end = EndView(about)
            self.now = NowView(desk)
            await pieces.pause()
            self.images = ImagesView(desk)
            await pieces.pause()
            with ui.element("div").classes("ce-columns"):
                self.figures = FiguresView(about)
                await pieces.pause()
                self.picks = PicksView(about)
                await self.picks.build(pieces)
        desk.rounds.add(client.id, self._refresh)
        client.on_delete(lambda: desk.rounds.remove(client.id))

    def _refresh(self) -> None:
        shot = self._desk.snapshot
        self.images.refresh(shot)
        self.now.refresh_pace()
        self.stop.set_enabled(shot.stage is Stage.PACKS and not self._desk.asked.stop)
        if shot is self._shown:
            return
        self._shown = shot
        pace = pace_words(shot.pace, fast=self._desk.asked.fast)
        self.status.set_text("A simulation" + ("; it has ended" if shot.stage is Stage.ENDED else pace))
        for view in (self.end, self.now, self.figures, self.picks):
            view.refresh(shot)

    async def _stop(self) -> None:
        if await confirmed(QUESTION, "End the run"):
            self._desk.asked.stop = True
