"""Logs of this rig: drawn, and to be downloaded."""

from contextlib import suppress
from functools import partial
from io import BytesIO
from pathlib import Path

from nicegui import ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces
from layflat.pages.panel.desk import Desk

MAX_LISTED = 12  # logs that are listed, the newest first
LISTED_WITHIN, LONGEST_DRAWING = 10.0, 120.0  # of the list, and of one picture, s


class LogsView:
    """The newest logs of the desk's folder."""

    def __init__(self, desk: Desk) -> None:
        """Build it; `list_logs` shows what there is."""
        self._desk, self._client = desk, ui.context.client
        with ui.row().classes("lf-line"):
            theme.button("Look again", self.list_logs, icon="refresh")
            ui.label(f"in {desk.folder}; the one being written can be read once the rig is let go of.").classes(
                "lf-quiet"
            )
        self.table = ui.element("div")
        self.told = ui.label("").props("role=status")
        self.cancel = theme.button("Cancel the drawing", self._end_drawing, icon="close")
        self._client.on_delete(self._end_drawing)
        self._client.on_delete(lambda: desk.worker.forget(self))
        self.cancel.set_visibility(False)

    async def list_logs(self) -> None:
        """List the newest logs."""
        try:
            call = partial(self._desk.worker.call, limit=LISTED_WITHIN, what="the list", by=self)
            logs = await call(newest_logs, self._desk.folder)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
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
        with ui.element("tr"):
            theme.text_element("td", path.name)
            theme.text_element("td", f"{size / 1e6:.1f} MB")
            with ui.element("td"):
                theme.button("Plot", partial(self._plot, path), icon="show_chart", hint=f"Draw {path.name}")
                hint = f"Download {path.name}"
                theme.button("Download", partial(self._download, path), icon="download", hint=hint)

    def _download(self, path: Path) -> None:
        if path.is_file():
            ui.download.file(path)
        else:
            self.told.set_text(f"{path.name} is not there any more: look again")

    def _end_drawing(self) -> None:
        self._desk.painter.cancel(self)

    async def _plot(self, path: Path) -> None:
        painter = self._desk.painter
        self.told.set_text(f"drawing {path.name}")
        self.cancel.set_visibility(True)
        try:
            what = f"the drawing of {path.name}"
            picture = await painter.call(drawn, path, limit=LONGEST_DRAWING, what=what, by=self)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        finally:
            self.cancel.set_visibility(False)
        if self._client.is_deleted:
            return
        self.told.set_text("")
        with ui.dialog() as dialog, ui.card().classes("lf-dialog-wide"):
            ui.image(picture).props(f'alt="Plots of {path.name}" fit=contain')
            theme.button("Close", dialog.close)
        await dialog
        dialog.delete()


def newest_logs(folder: Path) -> list[tuple[Path, int]]:
    """Return the newest logs of a folder, and their sizes in bytes, the newest first."""
    found = []
    for path in folder.glob("*.mcap"):
        with suppress(OSError):  # it went meanwhile
            state = path.stat()
            found.append((state.st_mtime, path, state.st_size))
    return [(path, size) for _, path, size in sorted(found, reverse=True)[:MAX_LISTED]]


def drawn(path: Path) -> str:
    """Return the figure of a log as a picture that a page can show; called in another process."""
    from base64 import b64encode  # noqa: PLC0415

    from layflat.plot.runs import run_figure  # noqa: PLC0415
    from layflat.rig.recorder.run import read_run  # noqa: PLC0415

    file = BytesIO()
    run_figure(read_run(path)).savefig(file, format="png", dpi=110)
    return f"data:image/png;base64,{b64encode(file.getvalue()).decode()}"
