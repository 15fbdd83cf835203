"""One look for all pages: colours with a contrast of at least 4.5, fonts of the system, a frame with a header, buttons.

Styles stand in one sheet of our own, so that a page needs neither Tailwind nor anything from the internet.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Literal

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

PRIMARY = "#0b3c5d"
ACCENT = "#1b6a8f"
DANGER = "#9b1c31"
WARNING = "#7a4b00"
GOOD = "#256029"
TEXT = "#1b1f24"
QUIET = "#4f5965"

FONT = "system-ui, -apple-system, 'Segoe UI', 'Liberation Sans', 'DejaVu Sans', sans-serif"

Kind = Literal["plain", "primary", "danger", "flat", "header"]
PROPS: dict[Kind, str] = {
    "plain": "outline no-caps color=primary",
    "primary": "unelevated no-caps color=primary",
    "danger": "unelevated no-caps color=negative",
    "flat": "flat no-caps color=primary",
    "header": "flat no-caps text-color=white",
}
LONG = 80  # characters of a message that takes more than a line
TONES = {"info": "info", "good": "check_circle", "warning": "warning", "danger": "error"}
"""Icons of notes by their tone: a tone is never told by its colour alone."""


@dataclass(frozen=True)
class Frame:
    """What a page is put into: `buttons` and `status` are rows in the header, `body` is what stands below it."""

    buttons: ui.row
    status: ui.row
    body: ui.element
    subtitle: ui.label


def text_element(tag: str, text: str = "") -> TextElement:
    """Return text in an element of a given tag, for example "h1"."""
    return TextElement(tag=tag, text=text)


def apply_theme() -> None:
    """Give the page of the current client our colours and styles."""
    ui.colors(
        primary=PRIMARY, secondary=ACCENT, accent=ACCENT, dark=TEXT, positive=GOOD, negative=DANGER, info=ACCENT,
        warning=WARNING,
    )  # fmt: skip
    sheet = files("layflat.pages.look").joinpath("theme.css").read_text(encoding="utf-8")
    ui.add_css(sheet.replace("FONT", FONT))


@contextmanager
def frame(title: str, subtitle: str = "") -> Iterator[Frame]:
    """Put what is made inside below a header with a title.

    Args:
        title: of the page and of the browser's tab.
        subtitle: what the page is about, for example the machine; `Frame.subtitle` changes it.
    """
    apply_theme()
    ui.page_title(f"{title} - {subtitle}" if subtitle else title)
    with ui.header().classes("lf-header"):
        with ui.element("div").classes("lf-titles"):
            text_element("h1", title)
            below = ui.label(subtitle).classes("lf-subtitle")
        status = ui.row().classes("lf-status")
        buttons = ui.row().classes("lf-buttons")
    body = ui.element("div").classes("lf-body")  # within the `main` that NiceGUI makes
    ui.skip_link("Skip to the content", target=body)
    with body:
        yield Frame(buttons, status, body, below)


def button(
    text: str, on_click: Callable[..., Any] | None = None, *, icon: str = "", kind: Kind = "plain", hint: str = ""
) -> ui.button:
    """Return a button; one without text needs a `hint`, which is its name for a reader of screens and its tooltip."""
    made = ui.button(text, on_click=on_click, icon=icon or None, color=None).props(PROPS[kind])
    made.classes("lf-button").props["aria-label"] = hint or text
    if hint:
        with made:
            ui.tooltip(hint)
    return made


@contextmanager
def panel(title: str, *, level: int = 2) -> Iterator[ui.element]:
    """Put what is made inside into a white box with a heading; yields the row of the heading."""
    with ui.element("section").classes("lf-panel") as box:
        box.props["aria-label"] = title
        with ui.element("div").classes("lf-panel-head") as head:
            text_element(f"h{level}", title)
        yield head


def note(text: str, tone: str = "info") -> ui.element:
    """Return a line with an icon: "info", "good", "warning" or "danger"."""
    with ui.element("div").classes(f"lf-note lf-{tone}").props("role=note") as box:
        ui.icon(TONES[tone]).props("aria-hidden=true")
        ui.label(text)
    return box


def say(text: str, tone: str = "good", *, stays: bool = False) -> None:
    """Show a message at the foot of the page for some seconds, or until it is closed.

    Args:
        text: of the message.
        tone: as of a `note`.
        stays: until the person closes it.
    """
    colour = {"good": "positive", "danger": "negative"}.get(tone, tone)
    ui.notify(
        text, color=colour, icon=TONES[tone], textColor="white", timeout=0 if stays else 5000,
        multi_line=len(text) > LONG, actions=[{"label": "Close", "color": "white"}],
    )  # fmt: skip
