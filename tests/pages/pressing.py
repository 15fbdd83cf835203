"""Every button of a page, as the page itself lists them, and hard values for every field that it has."""

import re
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from tests.pages.visitor import Found, Visitor

Element = tuple[int, Found]
TEXTS = ["", "x" * 5000, "../../etc/passwd", "é\0\u2603 'quoted' <b>", "1e400", "nan", "inf mm", "a name"]
NUMBERS = ["", "1e308", "-1e9", "0", "0.001", "-3.25", None, "7"]

IN_DIALOG = " (in a dialog)"
MAX_OPENED = 4  # times that a dialog is opened for its buttons
VALUES, THEN = ("update:modelValue", "update:value"), ("change", "blur", "keydown")  # kinds of events of a field


def name_of(found: Found) -> str:
    """The name of an element for readers of screens, without the numbers in it."""
    props = found.get("props", {})
    name = str(props.get("aria-label") or props.get("label") or found.get("text") or "")
    return " ".join(re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "", name).split())


def hard_values(visitor: Visitor, found: Found) -> list[Any]:
    """Values that a browser may send for an element; empty for elements without values."""
    tag, props = str(found.get("tag")), found.get("props", {})
    values: dict[str, list[Any]] = {
        "q-slider": [props.get("min"), props.get("max"), None],
        "nicegui-select": [*props.get("options", []), None],
        "q-btn-toggle": [*range(len(props.get("options", [])))],
        "q-tabs": [one.get("props", {}).get("name") for one in children(visitor, found)],
        "q-checkbox": [False, True],
        "q-toggle": [False, True],
        "nicegui-expansion": [True],
        "q-input": NUMBERS if props.get("type") == "number" else TEXTS,
        "nicegui-input": TEXTS,
    }
    return values.get(tag, [])


def children(visitor: Visitor, found: Found) -> list[Found]:
    """Elements inside an element."""
    everything = dict(visitor.each())
    return [everything[number] for number in found.get("children", []) if number in everything]


class Presser:
    """Presses the buttons of a visitor's page, each once, those that appeared last first.

    Args:
        visitor: of the page.
        before: called before each press with the number of it.
        after: called after each press with the button's name.
    """

    def __init__(
        self, visitor: Visitor, before: Callable[[int], object], after: Callable[[str], object] = lambda _: None
    ) -> None:
        self._visitor, self._before, self._after = visitor, before, after
        self.pressed: dict[str, int] = {}  # how often, by the names of buttons
        self._shown: dict[str, float] = {}  # since when each button is seen
        self._openers: dict[str, str] = {}  # what was pressed last before each button in a dialog was seen first
        self._last = ""

    def buttons(self) -> dict[str, Element]:
        """The buttons that can be seen, by their names; those in dialogs have names of their own."""
        found: dict[str, Element] = {}
        inside = {
            child for _, one in self._visitor.each() if one.get("tag") == "nicegui-dialog" for child in self._below(one)
        }
        for number, one in self._visitor.each():
            if one.get("tag") == "q-btn" and "hidden" not in one.get("class", []):
                name = name_of(one) + IN_DIALOG * (number in inside)
                found.setdefault(name, (number, one))
                if number in inside:
                    self._openers.setdefault(name, self._last)
        now = time.monotonic()
        self._shown = {name: self._shown.get(name, now) for name in found}
        return found

    def _below(self, found: Found) -> set[int]:
        everything, below, new = dict(self._visitor.each()), set[int](), list(found.get("children", []))
        while new:
            number = new.pop()
            below.add(number)
            new += everything.get(number, {}).get("children", [])
        return below

    @property
    def left(self) -> set[str]:
        """Names of all buttons of the page, and of dialogs that were open, that were not pressed."""
        here = {name_of(one) for _, one in self._visitor.each() if one.get("tag") == "q-btn"}
        return (here | set(self._openers)) - {name.removesuffix(IN_DIALOG) for name in self.pressed} - set(self.pressed)

    def due(self, leave: set[str]) -> str:
        """The name of the button to press next, of those that can be pressed now and are not to be left; else ""."""
        found = [
            name for name, (_, one) in self.buttons().items()
            if not one.get("props", {}).get("disable") and name not in leave
        ]  # fmt: skip
        due = [name for name in found if name not in self.pressed]
        due = due or [
            opener for name, opener in self._openers.items()
            if name not in self.pressed and opener in found and self.pressed[opener] < MAX_OPENED
        ]  # fmt: skip
        return max(due, key=lambda name: self._shown[name], default="")

    def press_all(self, *, leave: set[str] = set(), quiet: float = 1.0) -> None:  # noqa: B006
        """Press all that can be pressed and was not yet, until nothing new has appeared for a while, s."""
        since = time.monotonic()
        while time.monotonic() - since < quiet:
            if name := self.due(leave):
                self.press(name)
                since = time.monotonic()
            else:
                time.sleep(0.02)

    def press(self, name: str) -> None:
        """Press a button, or hold it for a moment where it is one to hold; wait until it can be seen."""
        self._visitor.until(lambda: name in self.buttons())
        button, self._last = self.buttons()[name], name
        self._before(sum(self.pressed.values()))
        self.pressed[name] = self.pressed.get(name, 0) + 1
        jog = button[1].get("props", {}).get("data-jog")
        if jog:
            self._visitor.jogs = [jog]
            time.sleep(0.2)
            self._visitor.jogs = []
        else:
            with suppress(AssertionError):  # it went meanwhile
                self._visitor.emit(button, "click")
        self._after(name)

    def fill(self, turn: int) -> None:
        """Put hard values into all fields of the page."""
        for element in self._visitor.each():
            put(self._visitor, element, turn)


def put(visitor: Visitor, element: Element, turn: int) -> None:
    """Put a hard value into a field, another one each turn, as a person does who goes on to the next field then."""
    values = hard_values(visitor, element[1])
    kinds = [kind for kind in VALUES if values and visitor._listener(element[1], kind)]
    for kind in [*kinds, *(THEN if kinds else ())]:
        if visitor._listener(element[1], kind):
            visitor.emit(element, kind, values[turn % len(values)] if kind in VALUES else None)
