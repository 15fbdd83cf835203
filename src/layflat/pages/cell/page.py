"""Page of a run: present action, camera image, results, and a button that ends the run."""

from importlib.resources import files

from nicegui import ui

from layflat.pages.cell.desk import RunFeed
from layflat.pages.cell.snapshot import RunSnapshot, RunStage
from layflat.pages.cell.views import EndView, ImagesView, NowView, PickFiguresView, PicksView, describe_pace
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces, wait_for_browser
from layflat.pages.look.theme import confirm

STOP_QUESTION = "End the run? What was done so far is kept, and its results are marked as partial."


async def run_page(feed: RunFeed) -> None:
    """Build the page of a browser's tab within the present client, once its browser is there."""
    if await wait_for_browser():
        await RunPage(feed).build()


class RunPage:
    """Page of a run in one browser tab."""

    def __init__(self, feed: RunFeed) -> None:
        """Store the feed that the page shows; `build` makes its elements."""
        self._feed = feed
        self._shown: RunSnapshot | None = None

    async def build(self) -> None:
        """Build it within the present client, piece by piece, and keep it up to date."""
        feed, about, pieces, client = self._feed, self._feed.about, Pieces(), ui.context.client
        ui.add_css(files("layflat.pages.cell").joinpath("cell.css").read_text(encoding="utf-8"))
        with theme.frame("Packing cell", f"{about.cell} with {about.machine}, seed {about.seed}") as frame:
            with frame.status:
                self.status = ui.label().props("id=cell-status")
            with frame.buttons:
                self.stop = theme.button("Stop", self._stop, icon="front_hand", kind="danger")
                self.stop.classes("ce-stop").props("id=cell-stop")
            await pieces.pause()
            self.end = EndView(about)
            self.now = NowView(feed)
            await pieces.pause()
            self.images = ImagesView(feed)
            await pieces.pause()
            with ui.element("div").classes("ce-columns"):
                self.figures = PickFiguresView(about)
                await pieces.pause()
                self.picks = PicksView(about)
                await self.picks.build(pieces)
        feed.rounds.add(client.id, self._refresh)
        client.on_delete(lambda: feed.rounds.remove(client.id))

    def _refresh(self) -> None:
        """Refresh images, pace and stop button; the other views only if the snapshot has changed."""
        shot = self._feed.snapshot
        self.images.refresh(shot)
        self.now.refresh_pace()
        self.stop.set_enabled(shot.stage is RunStage.PACKS and not self._feed.requests.stop)
        if shot is self._shown:
            return
        self._shown = shot
        pace = describe_pace(shot.pace, fast=self._feed.requests.full_speed)
        self.status.set_text("A simulation" + ("; it has ended" if shot.stage is RunStage.ENDED else pace))
        for view in (self.end, self.now, self.figures, self.picks):
            view.refresh(shot)

    async def _stop(self) -> None:
        """Request the end of the run, after a question."""
        if await confirm(STOP_QUESTION, "End the run"):
            self._feed.requests.stop = True
