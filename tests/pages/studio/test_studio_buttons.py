"""Every button of the studio, as the page lists it, with hard values in all fields."""

import time
from pathlib import Path

import pytest

from tests.pages.browsers import served
from tests.pages.pressing import Element, Presser, hard_values, put
from tests.pages.turning import KEPT, Turns
from tests.pages.visitor import Visitor

pytestmark = [pytest.mark.compiled, pytest.mark.realtime]
BOUND = 0.04  # of the loop's work in one turn, s; the longest is half of it where nobody else works
UNCHANGED = "Back to "  # before the names of buttons that are there once their value was changed
FOUND = "Take these gains"  # which are found after minutes
UNDO, REDO = "Undo (Ctrl-Z)", "Redo (Ctrl-Shift-Z)"
SECTION = "nicegui-expansion"
SECTIONS = ("Hose", "Controller", "Brake", "Arm")  # whose values are on the page


def fields_of(visitor: Visitor) -> list[Element]:
    """The fields that are on the page, once a slider is: some presses build the page anew. Sections stay open."""
    found: list[Element] = []

    def are_there() -> bool:
        found[:] = [one for one in visitor.each() if hard_values(visitor, one[1]) and one[1]["tag"] != SECTION]
        return any(map(is_slider, found))

    visitor.until(are_there)
    return found


def is_slider(element: Element) -> bool:
    """Whether a field is a slider."""
    return bool(element[1]["tag"] == "q-slider")


def edit(visitor: Visitor, turn: int) -> None:
    """Put a hard value into a field, and another one, which the checks may take, into a slider."""
    fields = fields_of(visitor)
    sliders = list(filter(is_slider, fields))
    put(visitor, fields[(7 * turn) % len(fields)], turn)
    put(visitor, sliders[(5 * turn) % len(sliders)], turn % 2)


def make_undoable(visitor: Visitor) -> None:
    """Edit until there is something to undo: nothing is where a reload of the file came last."""
    for turn in range(100):
        if visitor.enabled(UNDO):
            return
        edit(visitor, turn)
        time.sleep(0.2)


def is_shown(visitor: Visitor) -> bool:
    """Whether results are shown."""
    return visitor.text_of("st-value") not in {"", "..."}


def test_every_button_with_hard_values(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('extends = "paper-arm"\nname = "mine"\n[arm]\npayload = "2 kg"\n')
    with served(tmp_path, "studio", "mine.toml", before=KEPT) as found, Visitor(found.link) as visitor:
        visitor.until(lambda: is_shown(visitor), 200.0)
        turns = Turns(tmp_path)
        for name in SECTIONS:
            visitor.emit(*visitor.find(name, "update:modelValue"), True)
        (tmp_path / "mine.toml").write_text('extends = "paper-arm"\nname = "mine"\n[arm]\npayload = "3 kg"\n')
        visitor.until(lambda: "has changed on the disk" in visitor.text)
        presser = Presser(visitor, lambda turn: edit(visitor, turn))
        presser.press_all(quiet=3.0)
        after_edits = Presser(visitor, lambda _: None)
        make_undoable(visitor)
        for name in (UNDO, REDO):
            visitor.until(lambda name=name: visitor.enabled(name))  # type: ignore[misc]
            after_edits.press(name)
        left = {name for name in presser.left - after_edits.pressed.keys() if not name.startswith(UNCHANGED)}
        assert left <= {FOUND}, f"could not be pressed: {left}"
        longest = turns.longest()
    assert longest.work < BOUND, longest
    assert {path.name for path in tmp_path.iterdir()} >= {"mine.toml", "turns.jsonl"}
