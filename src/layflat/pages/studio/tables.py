"""Figures of a design in tiles and in a table beside those of A, and what the design rules find."""

from nicegui import ui

from layflat.design.findings import Finding
from layflat.pages.look import theme
from layflat.pages.look.pieces import Pieces
from layflat.pages.studio.box import WAITING, Panel
from layflat.pages.studio.cloud import Cloud
from layflat.pages.studio.results import Quantity, differences, share
from layflat.pages.studio.session import Session, Shown

TILES = {
    "torque, greatest": "torque",
    "strap safety": "strap safety",
    "mass of the joint": "mass",
    "air of the move, nominal": "air per move",
    "settled, half of all runs": "settled, median",
    "settled, 95 % of all runs": "settled, 95 %",
}
"""Figures that are seen at once, and their short names."""

ROWS = 15
TONES = {"error": "danger", "warning": "warning", "note": "info"}


class Tiles:
    """The main figures, large."""

    def __init__(self) -> None:
        self._values: dict[str, ui.label] = {}
        self._units: dict[str, ui.label] = {}
        self._more: dict[str, ui.label] = {}
        with ui.element("dl").classes("st-tiles") as self.box:
            for name, short in TILES.items():
                with ui.element("div").classes("st-tile"):
                    theme.text_element("dt", short)
                    with ui.element("dd"):
                        with ui.element("div").classes("st-figure"):
                            self._values[name] = ui.label("...").classes("st-value")
                            self._units[name] = ui.label().classes("lf-quiet lf-small")
                        self._more[name] = ui.label().classes("st-more")

    def show(self, now: list[Quantity], other: list[Quantity]) -> None:
        """Show figures, and beneath them what they have more than those of A."""
        known = {one.name: (one, share(one, beside)) for one, beside, _ in differences(now, other)}
        for name, label in self._values.items():
            one, more = known.get(name, (None, ""))
            label.set_text(one.number if one is not None else "none")
            self._units[name].set_text(one.unit if one is not None and one.known else "")
            self._more[name].set_text(more)

    def current(self, yes: bool) -> None:
        """Show whether they belong to the newest edit."""
        self.box.classes(add="" if yes else "st-old", remove="st-old" if yes else "")


class FiguresView(Panel):
    """All figures of the design, those of A, and the difference."""

    def __init__(self) -> None:
        super().__init__("Figures")
        self._rows: list[list[ui.label]] = []
        self._boxes: list[ui.element] = []
        with self.content, ui.element("table").classes("lf-table"):
            with ui.element("thead"), ui.element("tr"):
                for name in ("figure", "now", "A", "now less A"):
                    theme.text_element("th", name).props("scope=col")
            self._body = ui.element("tbody")

    async def build(self, pieces: Pieces) -> None:
        """Make the rows of the table, piece by piece."""
        with self._body:
            for _ in range(ROWS):
                with ui.element("tr") as row:
                    self._boxes.append(row)
                    self._rows.append([_cell() for _ in range(4)])
                await pieces.pause()

    def show(self, now: list[Quantity], other: list[Quantity]) -> None:
        """Show figures and those of A."""
        compared = differences(now, other)
        for i, (box, cells) in enumerate(zip(self._boxes, self._rows, strict=True)):
            box.set_visibility(i < len(compared))
            if i < len(compared):
                one, known, more = compared[i]
                for cell, text in zip(cells, (one.name, one.text, known.text if known else "", more), strict=True):
                    cell.set_text(text)


def _cell() -> ui.label:
    with ui.element("td"):
        return ui.label()


class FindingsView:
    """Table of the findings of the design rules and checks, worst first."""

    def __init__(self) -> None:
        self._box = ui.element("div").classes("st-findings")
        self._box.props('role=region aria-label="Design rules" aria-live=polite')
        self._shown: list[Finding] | None = None

    def show(self, findings: list[Finding], origin: str, *, known: bool = True) -> None:
        """List findings; `known`: whether the rules have been asked by now."""
        if findings == self._shown:
            return
        self._shown = list(findings) if findings or known else None
        self._box.clear()
        with self._box:
            if not findings and known:
                theme.note("The design rules find nothing.", "good")
            elif not findings:
                theme.note(WAITING)
            for one in findings:
                text = str(one).removeprefix(f"{origin}: ")
                theme.note(f"{one.severity.capitalize()}: {text}", TONES[one.severity])


def quantities(session: Session) -> tuple[list[Quantity], list[Quantity]]:
    """Return the figures of a session's design, and of the one that is kept as A."""
    return _of(session.shown), [] if session.kept is None else _of(session.kept.shown)


def _of(shown: Shown) -> list[Quantity]:
    found = shown.figures.quantities if shown.figures is not None else []
    return found + (shown.cloud.quantities if isinstance(shown.cloud, Cloud) else [])
