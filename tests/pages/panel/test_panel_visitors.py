"""Many visitors of a panel, some of whom come, go and press what they may not: the arm moves on, whoever drives it."""

import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path

import pytest

from layflat.rig.lease import HELD_AFTER
from tests.pages.browsers import PATIENT
from tests.pages.panel.arm import ANSWERED, LAPSES, OBEYS, PATIENCE, longest_gap, moved
from tests.pages.pressing import Element
from tests.pages.turning import KEPT
from tests.pages.visitor import Visitor

pytestmark = pytest.mark.realtime
BOUND = 0.04  # of the loop's work in one turn, s; the longest is half of it where nobody else works
MANY = 12  # pages


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


def visited(folder: Path, before: str) -> tuple[float, float, float]:
    """Let visitors come; returns the longest work of a turn, time without a renewal, and time from Stop on, s."""
    with moved(folder, before + LAPSES) as (driver, turns), Visitor(driver.link) as other:
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


def test_visitors_hold_up_nothing(tmp_path: Path) -> None:
    for attempt in "abc":  # others on the computer may take the processors just then
        (folder := tmp_path / attempt).mkdir()
        work, gap, took = visited(folder, KEPT if attempt in "ab" else KEPT + PATIENT)
        assert work < BOUND
        if gap < (HELD_AFTER if attempt in "ab" else PATIENCE) and took < ANSWERED:
            return
    raise AssertionError(f"no renewal for {gap:.3f} s; stopped after {took:.3f} s")
