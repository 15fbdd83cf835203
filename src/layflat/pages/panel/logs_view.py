"""View of the logs of a rig: drawn or downloaded."""

from contextlib import suppress
from functools import partial
from io import BytesIO
from pathlib import Path

from nicegui import ui

from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces
from layflat.pages.panel.desk import Desk

MAX_LISTED = 12  # logs that are listed, the newest first
LISTING_TIMEOUT, DRAWING_TIMEOUT = 10.0, 120.0  # of the list, and of one picture, s


class LogsView:
    """View of the newest logs of the desk's folder."""

    def __init__(self, desk: Desk) -> None:
        """Build it, empty; `list_logs` fills it."""
        self._desk, self._client = desk, ui.context.client
        with ui.row().classes("lf-line"):
            theme.button("Look again", self.list_logs, icon="refresh")
            ui.label(f"in {desk.folder}; the one being written can be read once the rig is let go of.").classes(
                "lf-quiet"
            )
        self.table = ui.element("div")
        self.status = ui.label("").props("role=status")
        self.cancel = theme.button("Cancel the drawing", self._end_drawing, icon="close")
        self._client.on_delete(self._end_drawing)
        self._client.on_delete(lambda: desk.worker.forget(self))
        self.cancel.set_visibility(False)

    async def list_logs(self) -> None:
        """List the newest logs in the table, or show an error as the status."""
        with theme.show_errors_on(self.status):
            call = partial(self._desk.worker.call, limit=LISTING_TIMEOUT, what="the list", by=self)
            await self._draw_list(await call(newest_logs, self._desk.folder))

    async def _draw_list(self, logs: list[tuple[Path, int]]) -> None:
        """Show the logs, (path, size in bytes), in short pieces; return early once page or table was removed."""
        if self._client.is_deleted:
            return
        pieces = Pieces()
        self.table.clear()
        with self.table:
            if not logs:
                ui.label("No whole log yet.").classes("lf-quiet")
                return
            with ui.element("table").classes("lf-table") as table:
                for log in logs:
                    self._draw_row(*log)
                    await pieces.pause()
                    if table.is_deleted:
                        return  # a newer list is being made

    def _draw_row(self, path: Path, size: int) -> None:
        """Add the row of a log: name, size (MB), and buttons that plot and download it."""
        with ui.element("tr"):
            theme.text_element("td", path.name)
            theme.text_element("td", f"{size / 1e6:.1f} MB")
            with ui.element("td"):
                theme.button("Plot", partial(self._show_plot, path), icon="show_chart", hint=f"Draw {path.name}")
                hint = f"Download {path.name}"
                theme.button("Download", partial(self._download, path), icon="download", hint=hint)

    def _download(self, path: Path) -> None:
        """Send a log to the browser; a log that was deleted since gives a line of status."""
        if path.is_file():
            ui.download.file(path)
        else:
            self.status.set_text(f"{path.name} is not there any more: look again")

    def _end_drawing(self) -> None:
        self._desk.painter.cancel(self)

    async def _show_plot(self, path: Path) -> None:
        """Render the plots of a log in another process and show them in a dialog; on failure show the error."""
        painter = self._desk.painter
        self.status.set_text(f"drawing {path.name}")
        self.cancel.set_visibility(True)
        with theme.show_errors_on(self.status):
            try:
                what = f"the drawing of {path.name}"
                picture = await painter.call(render_log, path, limit=DRAWING_TIMEOUT, what=what, by=self)
            finally:
                self.cancel.set_visibility(False)
            if not self._client.is_deleted:
                self.status.set_text("")
                with ui.dialog() as dialog, ui.card().classes("lf-dialog-wide"):
                    ui.image(picture).props(f'alt="Plots of {path.name}" fit=contain')
                    theme.button("Close", dialog.close)
                await dialog
                theme.remove_dialog(dialog)


def newest_logs(folder: Path) -> list[tuple[Path, int]]:
    """Return the `MAX_LISTED` newest MCAP files of a folder with their sizes in bytes, the last modified first."""
    logs = []
    for path in folder.glob("*.mcap"):
        with suppress(OSError):  # it was deleted meanwhile
            state = path.stat()
            logs.append((state.st_mtime, path, state.st_size))
    return [(path, size) for _, path, size in sorted(logs, reverse=True)[:MAX_LISTED]]


def render_log(path: Path) -> str:
    """Return the figure of a log as a data URL of a PNG image; called in another process."""
    from base64 import b64encode  # noqa: PLC0415

    from layflat.plot.runs import run_figure  # noqa: PLC0415
    from layflat.rig.recorder.run import read_run  # noqa: PLC0415

    file = BytesIO()
    run_figure(read_run(path)).savefig(file, format="png", dpi=110)
    return f"data:image/png;base64,{b64encode(file.getvalue()).decode()}"
