"""Whatever is pressed, searched and visited on the panel while an arm moves: it holds nothing up."""

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from statistics import median

import pytest

from layflat.rig.session import HELD_AFTER
from tests.pages.browsers import PATIENT
from tests.pages.panel.arm import ANSWERED, LAPSES, OBEYS, PATIENCE, longest_gap, moved, moving
from tests.pages.panel.hand import Hand
from tests.pages.pressing import Element
from tests.pages.turning import KEPT, Turns
from tests.pages.visitor import Visitor

pytestmark = pytest.mark.realtime
PLACES = 200  # out of reach
MANY = 12  # pages
SEARCHING, WORKING = 0.02, 0.04  # bounds of the loop's work in one turn, s; the longest is half where nobody else works
AXES = ("tip x (mm)", "tip y (mm)", "tip z (mm)")
Driven = tuple[Path, Visitor, Turns]


class Arms:
    """Arms that move, one at a time; as one takes a while to start, it serves the next test too if nothing failed."""

    def __init__(self) -> None:
        self._running, self._driven = ExitStack(), list[Driven]()

    def driven(self, attempt: str, folder: Path) -> Driven:
        """Return one for an attempt; others on the computer may take the processors, so the last one is patient."""
        if attempt != "a" or not self._driven:
            self.end()
            (own := folder / attempt).mkdir()
            before = KEPT + (PATIENT if attempt == "c" else "") + LAPSES
            self._driven = [(own, *self._running.enter_context(moved(own, before)))]
        (driven,) = self._driven
        driven[1].until(lambda: moving(driven[1]), 60.0)
        return driven

    def end(self) -> None:
        self._running.close()
        self._driven.clear()


@pytest.fixture(scope="module")
def arms() -> Iterator[Arms]:
    found = Arms()
    yield found
    found.end()


def searched(visitor: Visitor, number: int) -> None:
    """Search angles for a place that the arm does not reach."""
    for name, value in zip(AXES, (10.0 * (number % 7), -5.0 * (number % 11), 1200.0 + number), strict=True):
        visitor.enter(name, value)
    visitor.press("Find angles that bring the tip there")


def out_of_reach(visitor: Visitor) -> tuple[bool, float]:
    """Search places that are out of reach; returns whether the arm was held, and how long it took to stop it, s."""
    for number in range(PLACES):
        searched(visitor, number)
        time.sleep(0.02)
        if visitor.text_of("lf-state") not in {"Moving", "Ready"}:
            return True, 0.0
    visitor.until(lambda: "out of the arm's reach" in visitor.text, 60.0)
    searched(visitor, 0)  # one goes on when the arm is stopped
    visitor.press("Stop")
    return False, visitor.until(lambda: visitor.text_of("lf-state") == "Holding")


def test_two_hundred_places_out_of_reach_hold_up_nothing(arms: Arms, tmp_path: Path) -> None:
    """The event loop is free whatever is searched."""
    for attempt in "abc":
        _, visitor, turns = arms.driven(attempt, tmp_path)
        turns.begin()
        held, took = out_of_reach(visitor)
        longest = turns.longest()
        assert longest.work < SEARCHING, longest
        if not held and took < ANSWERED:
            return
    raise AssertionError(f"held: {held}; stopped after {took:.3f} s")


def press_all(other: Visitor, driver: Visitor) -> None:
    """Press every button of a page that looks on, those that can't be pressed as well, and renew as if it drove."""
    renews: Element | None = None
    for element in other.each():
        if element[1].get("tag") == "q-btn" and other._listener(element[1], "click"):
            other.emit(element, "click")
        if other._listener(element[1], "renew"):
            renews = element
        if other._listener(element[1], "stop"):
            other.emit(element, "stop", None)
    assert renews is not None
    for _ in range(50):
        other.emit(renews, "renew", {"beat": driver.beat, "jogs": ["0:1", "1:-1"]})


def take_away_twice(other: Visitor) -> None:
    """Take a step away by two presses of one button: the step behind it stays."""
    for _ in range(3):
        other.press("Add present angles")
    other.until(lambda: any(other.named("Take step 3 away")))
    button = other.find("Take step 1 away", "click")[0]
    for _ in range(2):
        other.emit(button, "click")
    other.until(lambda: not any(other.named("Take step 3 away")))
    time.sleep(0.3)
    assert any(other.named("Take step 2 away"))


def leave_while_it_works(link: str) -> None:
    """Open a page, ask for what takes a while, and leave before the answer."""
    with Visitor(link) as other:
        other.until(lambda: any(other.named("Look again")))
        for axis, value in zip("xyz", (0, 0, 1200), strict=True):
            other.enter(f"tip {axis} (mm)", value)
        for name in ("Find angles that bring the tip there", "Look again", "Save", "Back to what is in use"):
            other.press(name)
        other.press("Add present angles")


def come_back(other: Visitor) -> None:
    """Lose the line of a page, and come back to it before it is forgotten."""
    other.line.close()
    other.__enter__()
    other.press("Clear")
    other.until(lambda: "No steps yet" in other.text)


def many(link: str) -> None:
    """Open many pages at once, look on for a while, and leave together."""
    with ThreadPoolExecutor(MANY) as pool, ExitStack() as stack:
        for visitor in pool.map(Visitor, [link] * MANY):
            stack.enter_context(visitor)
        time.sleep(4.0)


def visited(folder: Path, driver: Visitor, turns: Turns) -> tuple[float, float, float]:
    """Let visitors come; returns the longest work of a turn, time without a renewal, and time from Stop on, s."""
    with Visitor(driver.link) as other:
        other.until(lambda: any(other.named("Failures")) and "drives; this is" in other.text)
        since = time.monotonic()
        turns.begin()
        press_all(other, driver)
        take_away_twice(other)
        for _ in range(3):
            leave_while_it_works(driver.link)
        come_back(other)
        others = get_context("spawn").Process(target=many, args=(driver.link,))  # it would take this one's time
        others.start()
        driver.until(lambda: others.exitcode is not None, 60.0)
        assert "drives; this is" not in driver.text, driver.text[:300]
        gap = longest_gap(folder, since)
        if driver.text_of("lf-state") not in OBEYS:
            return turns.longest().work, gap, 1.0
        driver.press("Stop")
        took = driver.until(lambda: driver.text_of("lf-state") not in OBEYS)
        return turns.longest().work, gap, took


def test_visitors_hold_up_nothing(arms: Arms, tmp_path: Path) -> None:
    """Some come, go and press what they may not: the arm moves on, whoever drives it."""
    for attempt in "abc":
        folder, driver, turns = arms.driven(attempt, tmp_path)
        work, gap, took = visited(folder, driver, turns)
        assert work < WORKING
        if gap < (HELD_AFTER if attempt in "ab" else PATIENCE) and took < ANSWERED:
            return
    raise AssertionError(f"no renewal for {gap:.3f} s; stopped after {took:.3f} s")


def pressed(folder: Path, visitor: Visitor, turns: Turns) -> tuple[Hand, float]:
    """Press everything; returns who did, and the longest time without a renewal, s."""
    with Visitor(visitor.link) as other:
        other.until(lambda: any(other.named("Failures")))
        turns.begin()
        since, hand = time.monotonic(), Hand(visitor, other)
        hand.press_everything()
        # A computer that is busy fails the check of timing, without which there is no check with air.
        left = hand.presser.left - ({"Check with air"} if "checks failed" in visitor.text else set())
        assert not left, f"could not be pressed: {left}"
        return hand, longest_gap(folder, since)


def test_every_button_while_the_arm_moves(arms: Arms, tmp_path: Path) -> None:
    for attempt in "abc":
        folder, visitor, turns = arms.driven(attempt, tmp_path)
        hand, gap = pressed(folder, visitor, turns)
        longest = turns.longest()
        assert longest.work < WORKING, longest
        if gap < (HELD_AFTER if attempt in "ab" else PATIENCE) and median(hand.answers) < ANSWERED:
            return
    raise AssertionError(f"no renewal for {gap:.3f} s; stopped after {hand.answers} s")
