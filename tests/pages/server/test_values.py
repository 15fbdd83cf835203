"""Elements take what a browser sends for them; anything else is ignored, and nothing else fails by it."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.pages.server.serving import ELEMENTS, serving
from tests.pages.visitor import Visitor

KEY = {"action": "keydown", "key": "a", "code": "KeyA", "location": 0, "repeat": False, "altKey": False,
       "ctrlKey": False, "metaKey": False, "shiftKey": False}  # fmt: skip
POINT = {"object_id": "x", "object_name": "reach", "point": {"x": 0.1, "y": 0, "z": 1.5}}
CLICK = {"click_type": "click", "button": 0, "alt_key": False, "ctrl_key": False, "meta_key": False,
         "shift_key": False, "hits": [POINT]}  # fmt: skip
TAKEN: dict[str, list[Any]] = {  # each differs from the one before
    "a number": ["12.5", 3, "1e308", "", "-0.25"],
    "a text": ["x", "é\u2603", "x" * 20_000, ""],
    "a slider": [7, 2.5, 1e300],
    "a choice": [{"value": 1, "label": "two"}, None, {"value": 2, "label": "three"}],
    "a toggle": [1, 0],
    "a box": [True, False],
    "a switch": [True, False],
    "a part": [True, False],
    "some tabs": ["second", "first"],
    "some panels": ["second", "first"],
    "a dialog": [True, False],
    "the keys": [KEY, KEY | {"ctrlKey": True}],
    "a scene": [CLICK, CLICK | {"hits": []}],
}
ANY: list[Any] = [
    None, True, 0, 1, -1, 5, 10**9, 10**400, 1e308, "", "banana", "1e999", "nan", "12.5", "\0", [], [[]], [1, 2],
    {}, {"value": 1}, {"value": "x"}, {"value": 10**6, "label": "two"}, {"value": -1, "label": "three"},
    {"value": 0, "label": "three"}, {"value": [1], "label": "two"}, {"args": 1}, KEY | {"key": None},
    KEY | {"repeat": 1}, CLICK | {"hits": 5}, CLICK | {"hits": [{}]}, CLICK | {"hits": [POINT | {"point": {"x": "a"}}]},
]  # fmt: skip
NUMBERS = [None, 0, 1, -1, 5, 10**9, 1e308]
TEXTS = ["", "banana", "1e999", "nan", "12.5", "\0"]
FITS: dict[str, list[Any]] = {  # of any, what a browser may send for an element; true for all others
    "a number": [*NUMBERS, "", "12.5"], "a text": [None, *TEXTS], "a slider": NUMBERS, "a choice": [None],
    "a toggle": [0, 1], "some tabs": [], "some panels": [], "the keys": [], "a scene": [],
}  # fmt: skip


def event_of(visitor: Visitor, name: str) -> tuple[tuple[int, Any], str]:
    """The element of a name, and the kind of event that carries its value."""
    return visitor.find(name, "update:modelValue", "update:value", "key", "click3d")


def taken(visitor: Visitor) -> int:
    return next(int(line.split()[0]) for line in visitor.text.splitlines() if line.endswith(" taken"))


def has_taken_more(visitor: Visitor, before: int) -> bool:
    return taken(visitor) > before


def test_elements_take_what_browsers_send(tmp_path: Path) -> None:
    with serving(tmp_path, page=ELEMENTS) as served, Visitor(served.link) as visitor:
        visitor.until(lambda: any(visitor.named("a scene")))
        for name, values in TAKEN.items():
            for value in values:
                before = taken(visitor)
                visitor.emit(*event_of(visitor, name), value)
                visitor.until(partial(has_taken_more, visitor, before), 5.0)


def test_elements_ignore_all_else(tmp_path: Path) -> None:
    complaints: list[str] = []
    with serving(tmp_path, complaints=complaints, page=ELEMENTS) as served:
        for name in TAKEN:
            with Visitor(served.link) as visitor:
                ignored(visitor, name)
    assert len(complaints) >= len(TAKEN)
    assert all("was ignored" in line for line in complaints), complaints


def ignored(visitor: Visitor, name: str) -> None:
    """An element ignores what no browser sends for it, and its page goes on."""
    visitor.until(lambda: any(visitor.named("a scene")))
    (number, one), kind = event_of(visitor, name)
    fits = list(map(json.dumps, FITS.get(name, [True])))
    wrong = [[text] for text in map(json.dumps, ANY) if text not in fits]
    for args in [*wrong, [], ['"x"', "1"], ['"\\ud800"'], ["1e999"]]:
        listener = visitor._listener(one, kind)
        visitor.say("event", {"id": number, "client_id": visitor.client, "listener_id": listener, "args": args})
    visitor.press("Greet")
    visitor.until(lambda: "hello from Python" in visitor.text)
    assert taken(visitor) == 0, name


@pytest.mark.parametrize("name", ["a number", "Greet"])
def test_events_for_nobody_are_ignored(tmp_path: Path, name: str) -> None:
    complaints: list[str] = []
    with serving(tmp_path, complaints=complaints, page=ELEMENTS) as served, Visitor(served.link) as visitor:
        visitor.until(lambda: any(visitor.named("a scene")))
        number = next(visitor.named(name))[0]
        for element, listener in ((number, "unknown"), (10**9, "unknown")):
            visitor.say("event", {"id": element, "client_id": visitor.client, "listener_id": listener, "args": ["1"]})
        visitor.say("event", {"id": number, "client_id": "unknown", "listener_id": "unknown", "args": ["1"]})
        visitor.press("Greet")
        visitor.until(lambda: "hello from Python" in visitor.text)
    assert len(complaints) == 1
    assert "is for a listener that its element does not have" in complaints[0]
