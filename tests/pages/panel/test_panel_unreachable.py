"""The pages' event loop is free whatever is searched: two hundred places out of reach while the arm moves."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from tests.pages.browsers import PATIENT, served
from tests.pages.turning import KEPT, Turns
from tests.pages.visitor import Visitor

pytestmark = pytest.mark.realtime
PLACES = 200
ANSWERED = 0.1  # from Stop to the page that tells it, s
BOUND = 0.02  # of the loop's work in one turn, s
OBEYS = {"Ready", "Moving"}
AXES = ("tip x (mm)", "tip y (mm)", "tip z (mm)")


def obeys(visitor: Visitor) -> bool:
    """Bring the air, or go on: a computer that is busy with something else may hold the arm at any time."""
    state = visitor.text_of("lf-state")
    name = {"Fault": "Reset", "Holding": "Go on"}.get(state, "Start")
    if state not in OBEYS and any(visitor.named(name)) and visitor.enabled(name):
        visitor.press(name)
        time.sleep(0.3)
    return state in OBEYS


def moving(visitor: Visitor) -> bool:
    """Let the arm go to and fro; whether it does."""
    if obeys(visitor) and visitor.text_of("lf-state") == "Ready" and visitor.enabled("Run again and again"):
        visitor.press("Run again and again")
        time.sleep(0.3)
    return visitor.text_of("lf-state") == "Moving"


@contextmanager
def trusted(folder: Path, before: str) -> Iterator[tuple[Visitor, Turns]]:
    """A visitor that drives a picking arm to and fro, and the turns of its server."""
    with served(folder, "panel", "picking-arm", before=before) as found, Visitor(found.link) as visitor:
        turns = Turns(folder)
        visitor.until(lambda: any(visitor.named("Failures")) and visitor.text_of("lf-state") == "Off", 300.0)
        visitor.until(lambda: obeys(visitor), 60.0)
        visitor.press("Add present angles")
        visitor.jogs = ["0:1"]
        time.sleep(1.5)
        visitor.jogs = []
        time.sleep(0.5)
        visitor.press("Add present angles")
        visitor.until(lambda: moving(visitor), 60.0)
        yield visitor, turns


def searched(visitor: Visitor, number: int) -> None:
    """Search angles for a place that the arm does not reach."""
    for name, value in zip(AXES, (10.0 * (number % 7), -5.0 * (number % 11), 1200.0 + number), strict=True):
        visitor.enter(name, value)
    visitor.press("Find angles that bring the tip there")


def test_two_hundred_places_out_of_reach_hold_up_nothing(tmp_path: Path) -> None:
    for attempt in "abc":  # others on the computer may take the processors just then
        (folder := tmp_path / attempt).mkdir()
        with trusted(folder, KEPT if attempt in "ab" else KEPT + PATIENT) as (visitor, turns):
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
