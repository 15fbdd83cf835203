"""From a page that looks on nothing is done at the rig, whatever it sends, and nothing that the rig can't do."""

import inspect
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from layflat.errors import LayflatError
from layflat.machine import load
from layflat.pages.panel.desk import Controls
from layflat.pages.panel.moves import SequenceStep

ARM = load("paper-arm")
GIVEN: dict[str, dict[str, Any]] = {
    "switch": {"output": "gripper", "on": True}, "jog": {"velocities": [0.1, 0.0]},
    "start_sequence": {"steps": [SequenceStep((0.1, 0.1))]},
    "change": {"machine": ARM}, "check": {"air": True, "tell": print},
}  # fmt: skip
TELL = {"start_sequence", "change", "check"}
ACTIONS = [name for name, _ in inspect.getmembers(Controls, inspect.isfunction) if not name.startswith("_")]


class Noted:
    """Stands for all that a desk has: it notes what is called."""

    def __init__(self, called: list[str], name: str = "") -> None:
        self._called, self._name = called, name

    def __getattr__(self, name: str) -> "Noted":
        return Noted(self._called, name)

    def __call__(self, *_: object, **__: object) -> object:
        self._called.append(self._name)
        return True


def controls(*, drives: bool) -> tuple[Controls, list[str]]:
    """Controls of a page, and what is called by them."""
    called: list[str] = []
    noted = Noted(called)
    operators = SimpleNamespace(drives=lambda key: drives and key == "page")
    desk: Any = SimpleNamespace(operators=operators, pilot=noted, link=noted, rounds=noted)
    return Controls(desk, "page", 0.5), called


@pytest.mark.parametrize("name", ACTIONS)
def test_a_page_that_looks_on_does_nothing(name: str) -> None:
    hand, called = controls(drives=False)
    told = pytest.raises(LayflatError, match="Drive from here") if name in TELL else nullcontext()
    with told:
        getattr(hand, name)(**GIVEN.get(name, {}))
    assert called == []


@pytest.mark.parametrize("name", sorted(set(ACTIONS) - {"check"}))
def test_a_page_that_drives_does_it(name: str) -> None:
    hand, called = controls(drives=True)
    getattr(hand, name)(**GIVEN.get(name, {}))
    assert called[0] == name


def test_a_move_through_no_places_is_told() -> None:
    hand, called = controls(drives=True)
    with pytest.raises(LayflatError, match="no steps"):
        hand.start_sequence([])
    assert called == []


def test_each_page_moves_at_its_own_speed() -> None:
    shares: list[float] = []
    operators = SimpleNamespace(drives=lambda _: True)
    pilot = SimpleNamespace(start_sequence=lambda _, share, repeats: not repeats and not shares.append(share))  # type: ignore[func-returns-value]
    desk: Any = SimpleNamespace(operators=operators, pilot=pilot)
    first, second = Controls(desk, "a", 0.3), Controls(desk, "b", 0.3)
    first.share = 1.0
    for one in (first, second):
        one.start_sequence([SequenceStep(tuple(np.zeros(2)))])
    assert shares == [1.0, 0.3]
