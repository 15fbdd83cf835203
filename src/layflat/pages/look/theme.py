"""Theme of all pages: colours with a contrast of at least 4.5, fonts of the system, a frame with a header, buttons.

Styles are in one sheet of our own, so that a page needs neither Tailwind nor anything from the internet.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files
from math import isfinite
from typing import Any, Literal

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

from layflat.errors import LayflatError
from layflat.pages.look.pieces import Pieces

PRIMARY_COLOUR = "#0b3c5d"
ACCENT_COLOUR = "#1b6a8f"
DANGER_COLOUR = "#9b1c31"
WARNING_COLOUR = "#7a4b00"
SUCCESS_COLOUR = "#256029"
TEXT_COLOUR = "#1b1f24"
QUIET_COLOUR = "#4f5965"

FONT_FAMILY = "system-ui, -apple-system, 'Segoe UI', 'Liberation Sans', 'DejaVu Sans', sans-serif"

ButtonKind = Literal["plain", "primary", "danger", "flat", "header"]
BUTTON_PROPS: dict[ButtonKind, str] = {
    "plain": "outline no-caps color=primary",
    "primary": "unelevated no-caps color=primary",
    "danger": "unelevated no-caps color=negative",
    "flat": "flat no-caps color=primary",
    "header": "flat no-caps text-color=white",
}
MAX_LINE_LENGTH = 80  # characters of a message in one line
TONE_ICONS = {"info": "info", "good": "check_circle", "warning": "warning", "danger": "error"}
"""Icons of notes by their tone: a tone is never shown by its colour alone."""


@dataclass(frozen=True)
class PageFrame:
    """Frame of a page: `buttons` and `status` are rows in the header, `body` is below it."""

    buttons: ui.row
    status: ui.row
    body: ui.element
    subtitle: ui.label


def text_element(tag: str, text: str = "") -> TextElement:
    """Add text in an element of a tag, for example "h1", to the current element, and return it."""
    return TextElement(tag=tag, text=text)


def apply_theme() -> None:
    """Apply our colours and styles to the page of the current client."""
    ui.colors(
        primary=PRIMARY_COLOUR,
        secondary=ACCENT_COLOUR,
        accent=ACCENT_COLOUR,
        dark=TEXT_COLOUR,
        positive=SUCCESS_COLOUR,
        negative=DANGER_COLOUR,
        info=ACCENT_COLOUR,
        warning=WARNING_COLOUR,
    )
    sheet = files("layflat.pages.look").joinpath("theme.css").read_text(encoding="utf-8")
    ui.add_css(sheet.replace("FONT", FONT_FAMILY))


@contextmanager
def frame(title: str, subtitle: str = "") -> Iterator[PageFrame]:
    """Build a page with a header, and yield its frame; elements made in the `with` block go below the header.

    Args:
        title: title of the page and of the browser's tab.
        subtitle: subject of the page, such as the machine; also in the tab's title, and changed later by
            `subtitle.set_text` of the frame.
    """
    apply_theme()
    ui.page_title(f"{title} - {subtitle}" if subtitle else title)
    with ui.header().classes("lf-header"):
        with ui.element("div").classes("lf-titles"):
            text_element("h1", title)
            subtitle_label = ui.label(subtitle).classes("lf-subtitle")
        status = ui.row().classes("lf-status")
        buttons = ui.row().classes("lf-buttons")
    body = ui.element("div").classes("lf-body")  # within the `main` that NiceGUI makes
    ui.skip_link("Skip to the content", target=body)
    with body:
        yield PageFrame(buttons, status, body, subtitle_label)


def button(
    text: str, on_click: Callable[..., Any] | None = None, *, icon: str = "", kind: ButtonKind = "plain", hint: str = ""
) -> ui.button:
    """Add a button to the current element, and return it.

    Args:
        text: text on the button; "" needs a `hint`.
        on_click: called when it is pressed.
        icon: name of a Material icon; "" for none.
        kind: appearance.
        hint: tooltip, and name for a reader of screens.
    """
    element = ui.button(text, on_click=on_click, icon=icon or None, color=None).props(BUTTON_PROPS[kind])
    element.classes("lf-button").props["aria-label"] = hint or text
    if hint:
        with element:
            ui.tooltip(hint)
    return element


@contextmanager
def panel(title: str) -> Iterator[ui.element]:
    """Yield the row of the heading of a white box; elements made inside are in the box."""
    with ui.element("section").classes("lf-panel") as box:
        box.props["aria-label"] = title
        with ui.element("div").classes("lf-panel-head") as head:
            text_element("h2", title)
        yield head


def figure(name: str) -> ui.label:
    """Add a name and its value, "-" at first, to the current element, a list (`dl`); return the label of the value."""
    with ui.element("div"):
        text_element("dt", name)
        with ui.element("dd"):
            return ui.label("-")


class LabelTable:
    """Table of labels: its rows are made once, and shown as far as there are texts for them."""

    def __init__(self, heads: Sequence[str], rows: int, props: str = "") -> None:
        """Make its head within the current element; `build` makes `rows` rows."""
        self._columns, self._count = len(heads), rows
        self._rows: list[tuple[ui.element, list[ui.label]]] = []
        with ui.element("table").classes("lf-table").props(props):
            with ui.element("thead"), ui.element("tr"):
                for head in heads:
                    text_element("th", head).props("scope=col")
            self._body = ui.element("tbody")

    async def build(self, pieces: Pieces) -> None:
        """Build the rows, piece by piece."""
        with self._body:
            for _ in range(self._count):
                with ui.element("tr") as box:
                    self._rows.append((box, [_cell() for _ in range(self._columns)]))
                box.set_visibility(False)
                await pieces.pause()

    def show(self, rows: Sequence[Sequence[str]]) -> None:
        """Show rows of texts, one text for each column; rows beyond those that the table has are left out."""
        for i, (box, cells) in enumerate(self._rows):
            box.set_visibility(i < len(rows))
            if i < len(rows):
                for label, text in zip(cells, rows[i], strict=True):
                    label.set_text(text)


def _cell() -> ui.label:
    """Add an empty cell to the current row of a table, and return its label."""
    with ui.element("td"):
        return ui.label()


def note(text: str, tone: str = "info") -> ui.element:
    """Add a line of text with the icon of a tone, "info", "good", "warning" or "danger", and return its box."""
    with ui.element("div").classes(f"lf-note lf-{tone}").props("role=note") as box:
        ui.icon(TONE_ICONS[tone]).props("aria-hidden=true")
        ui.label(text)
    return box


def show_message(text: str, tone: str = "good", *, stays: bool = False) -> None:
    """Show a message at the foot of the page for 5 s, or until it is closed.

    Args:
        text: text of the message.
        tone: tone as `note` has it.
        stays: until the person closes it.
    """
    colour = {"good": "positive", "danger": "negative"}.get(tone, tone)
    ui.notify(
        text, color=colour, icon=TONE_ICONS[tone], textColor="white", timeout=0 if stays else 5000,
        multi_line=len(text) > MAX_LINE_LENGTH, actions=[{"label": "Close", "color": "white"}],
    )  # fmt: skip


@contextmanager
def show_errors_on(label: ui.label) -> Iterator[None]:
    """Show the message of a LayflatError that is raised inside on a label, and suppress it."""
    try:
        yield
    except LayflatError as error:
        label.set_text(str(error))


def finite_number(value: Any) -> float | None:
    """Return the number that a field holds; None for text, a truth value, NaN, or a magnitude of 1e300 or more."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if abs(value) < 1e300 and isfinite(value) else None


def clamp_number(value: Any, lower: float, upper: float, otherwise: float) -> float:
    """Return the number that a slider or field holds, clamped to its limits.

    Args:
        value: value of the element.
        lower: lower limit.
        upper: upper limit.
        otherwise: returned where the element holds no finite number.
    """
    finite = finite_number(value)
    return otherwise if finite is None else min(max(finite, lower), upper)


def remove_dialog(dialog: ui.dialog) -> None:
    """Remove an answered dialog from the page, unless it was removed with the part of the page that opened it."""
    if not dialog.is_deleted:
        dialog.delete()


async def confirm(question: str, yes: str) -> bool:
    """Ask a question in a dialog, and return whether it was answered by the button `yes`; Escape means no."""
    with ui.dialog() as dialog, ui.card().classes("lf-dialog").props("role=dialog aria-modal=true"):
        ui.label(question)
        with ui.row().classes("lf-line"):
            button(yes, lambda: dialog.submit(True), kind="primary").props("autofocus")
            button("Cancel", lambda: dialog.submit(False))
    answer = await dialog
    remove_dialog(dialog)
    return bool(answer)
