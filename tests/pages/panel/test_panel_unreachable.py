"""The pages' event loop is free whatever is searched: two hundred places out of reach while the arm moves."""

import time
from pathlib import Path

import pytest

from tests.pages.browsers import PATIENT
from tests.pages.panel.arm import ANSWERED, moved
from tests.pages.turning import KEPT
from tests.pages.visitor import Visitor

pytestmark = pytest.mark.realtime
PLACES = 200
BOUND = 0.02  # of the loop's work in one turn, s
AXES = ("tip x (mm)", "tip y (mm)", "tip z (mm)")


def searched(visitor: Visitor, number: int) -> None:
    """Search angles for a place that the arm does not reach."""
    for name, value in zip(AXES, (10.0 * (number % 7), -5.0 * (number % 11), 1200.0 + number), strict=True):
        visitor.enter(name, value)
    visitor.press("Find angles that bring the tip there")


def test_two_hundred_places_out_of_reach_hold_up_nothing(tmp_path: Path) -> None:
    for attempt in "abc":  # others on the computer may take the processors just then
        (folder := tmp_path / attempt).mkdir()
        with moved(folder, KEPT if attempt in "ab" else KEPT + PATIENT) as (visitor, turns):
            turns.begin()
            for number in range(PLACES):
                searched(visitor, number)
                time.sleep(0.02)
                held = visitor.text_of("lf-state") not in {"Moving", "Ready"}
                if held:
                    break
            if not held:
                visitor.until(lambda: "out of the arm's reach" in visitor.text, 60.0)
                searched(visitor, 0)  # one goes on when the arm is stopped
                visitor.press("Stop")
                took = visitor.until(lambda: visitor.text_of("lf-state") == "Holding")
            longest = turns.longest()
        assert longest.work < BOUND, longest
        if not held and took < ANSWERED:
            return
    raise AssertionError(f"held: {held}" if held else f"stopped after {took:.3f} s")
