"""Results of picks: figures of all, a table of the last, and the failures."""

from collections import Counter
from math import isfinite

from nicegui import ui

from layflat.pages.cell.snapshot import ROWS, About, Snapshot
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces

FIGURES = {
    "picks": "Picks",
    "correct": "Correct so far",
    "results": "Results",
    "rate": "Rate",
    "air": "Air",
    "collisions": "Collisions",
    "false": "False detections",
    "time": "Time of the cell",
    "delivery": "Delivery",
}
"""Names of figures, by what stands in the ids of their elements."""

JUDGED = "Whether a pick is correct is judged by the scene's truth, for good once its delivery is over."


class FiguresView:
    """Figures of all picks."""

    def __init__(self, about: About) -> None:
        """Build it."""
        self._asked = about.picks
        self._values: dict[str, ui.label] = {}
        with theme.panel("Figures"):
            with ui.element("dl").classes("ce-figures").props("id=cell-figures"):
                for key, name in FIGURES.items():
                    with ui.element("div"):
                        theme.text_element("dt", name)
                        with ui.element("dd"):
                            self._values[key] = ui.label("-").props(f"id=cell-{key}")
            ui.label(JUDGED).classes("lf-quiet lf-small")

    def refresh(self, shot: Snapshot) -> None:
        """Show those of a snapshot."""
        found = shot.figures
        picks = found.picks
        each = f"{found.air_each:.1f} normal l a pick, {found.air:.0f} in all"
        texts = {
            "picks": f"{picks} of {self._asked}",
            "correct": f"{found.results['correct']} of {picks}",
            "results": _words(found.results),
            "rate": f"{found.picks_a_minute:.1f} a minute" if isfinite(found.picks_a_minute) else "-",
            "air": each if picks else "-",
            "collisions": f"{found.collisions}",
            "false": f"{found.false_detections}",
            "time": f"{shot.time:.1f} s",
            "delivery": f"{shot.delivery}",
        }
        for key, label in self._values.items():
            label.set_text(texts[key])


class PicksView:
    """The last picks, a row each, the newest first."""

    def __init__(self, about: About) -> None:
        """Build it."""
        self._columns = len(about.columns)
        self._rows: list[list[ui.label]] = []
        self._boxes: list[ui.element] = []
        self._remarks: tuple[str, ...] = ()
        with theme.panel("Last picks"):
            with (
                ui.element("div").classes("ce-table").props('tabindex=0 role=region aria-label="Table of picks"'),
                ui.element("table").classes("lf-table").props("id=cell-picks-table"),
            ):
                with ui.element("thead"), ui.element("tr"):
                    for name in about.columns:
                        theme.text_element("th", name).props("scope=col")
                self._body = ui.element("tbody")
            self._list = ui.element("ul").classes("ce-list").props("id=cell-remarks")

    async def build(self, pieces: Pieces) -> None:
        """Make the rows of the table, piece by piece."""
        with self._body:
            for _ in range(ROWS):
                self._add_row(self._columns)
                await pieces.pause()

    def _add_row(self, columns: int) -> None:
        with ui.element("tr") as box:
            self._boxes.append(box)
            self._rows.append([_cell() for _ in range(columns)])
        box.set_visibility(False)

    def refresh(self, shot: Snapshot) -> None:
        """Show those of a snapshot."""
        for i, (box, cells) in enumerate(zip(self._boxes, self._rows, strict=True)):
            box.set_visibility(i < len(shot.rows))
            if i < len(shot.rows):
                for label, text in zip(cells, shot.rows[i], strict=True):
                    label.set_text(text)
        if shot.remarks != self._remarks:
            self._remarks = shot.remarks
            self._list.clear()
            with self._list:
                for line in shot.remarks:
                    theme.text_element("li", line)


def _words(results: Counter[str]) -> str:
    return ", ".join(f"{count} {word}" for word, count in results.most_common()) or "-"


def _cell() -> ui.label:
    with ui.element("td"):
        return ui.label()
