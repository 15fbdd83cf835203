"""Logs of this rig: drawn, and to be downloaded."""

from io import BytesIO
from pathlib import Path

from nicegui import run, ui

from layflat.errors import LayflatError
from layflat.pages.look import theme
from layflat.pages.panel.desk import Desk

MOST = 12  # logs that are listed, the newest first


class LogsView:
    """The newest logs of the desk's folder."""

    def __init__(self, desk: Desk) -> None:
        """Build it."""
        self._desk = desk
        with ui.row().classes("lf-line"):
            theme.button("Look again", self._draw, icon="refresh")
            ui.label(f"in {desk.folder}; the one being written can be read once the rig is let go of.").classes(
                "lf-quiet"
            )
        self.table = ui.element("div")
        self.told = ui.label("").props("role=status")
        self._draw()

    def _draw(self) -> None:
        logs = sorted(self._desk.folder.glob("*.mcap"), key=lambda path: path.stat().st_mtime, reverse=True)
        self.table.clear()
        with self.table:
            if not logs:
                ui.label("No whole log yet.").classes("lf-quiet")
                return
            with ui.element("table").classes("lf-table"):
                for path in logs[:MOST]:
                    with ui.element("tr"):
                        theme.text_element("td", path.name)
                        theme.text_element("td", f"{path.stat().st_size / 1e6:.1f} MB")
                        with ui.element("td"):
                            hint = f"Draw {path.name}"
                            theme.button("Plot", lambda path=path: self._plot(path), icon="show_chart", hint=hint)
                            hint = f"Download {path.name}"
                            theme.button(
                                "Download", lambda path=path: ui.download.file(path), icon="download", hint=hint
                            )

    async def _plot(self, path: Path) -> None:
        self.told.set_text(f"drawing {path.name}")
        try:
            picture = await run.cpu_bound(drawn, path)
        except LayflatError as error:
            self.told.set_text(str(error))
            return
        self.told.set_text("")
        if picture is None:  # the page is being closed
            return
        with ui.dialog() as dialog, ui.card().classes("lf-dialog-wide"):
            ui.image(picture).props(f'alt="Plots of {path.name}" fit=contain')
            theme.button("Close", dialog.close)
        dialog.open()


def drawn(path: Path) -> str:
    """Return the figure of a log as a picture that a page can show; called in another process."""
    from base64 import b64encode  # noqa: PLC0415

    from layflat.plot.runs import run_figure  # noqa: PLC0415
    from layflat.rig.recorder.run import read_run  # noqa: PLC0415

    file = BytesIO()
    run_figure(read_run(path)).savefig(file, format="png", dpi=110)
    return f"data:image/png;base64,{b64encode(file.getvalue()).decode()}"
