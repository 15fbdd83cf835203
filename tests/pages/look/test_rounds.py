"""The page that drives is shown ten times a second, whoever else looks on; nothing holds the loop up for long."""

import asyncio
import logging
import time
from collections import Counter

import pytest

from layflat.pages.look.pieces import MAX_ROUND_TIME, Rounds

PAGES = 40
WORK = 0.01  # of one page, s


@pytest.mark.realtime
def test_the_page_that_drives_comes_first_and_all_others_have_their_turn() -> None:
    shown = Counter[str]()

    def show(key: str) -> None:
        shown[key] += 1
        time.sleep(WORK)

    async def go() -> float:
        rounds = Rounds(lambda key: key == "page 7")
        for number in range(PAGES):
            rounds.add(f"page {number}", lambda key=f"page {number}": show(key))  # type: ignore[misc]
        longest, before, end = 0.0, time.monotonic(), time.monotonic() + 3.0
        while time.monotonic() < end:
            await asyncio.sleep(0)
            longest, before = max(longest, time.monotonic() - before), time.monotonic()
        for number in range(PAGES):
            rounds.remove(f"page {number}")
        return longest

    longest = asyncio.run(go())
    assert longest < 0.5 * PAGES * WORK, "one page in a turn"
    others = [shown[f"page {number}"] for number in range(PAGES) if number != 7]
    assert shown["page 7"] > 10
    assert max(others) - min(others) <= 1
    assert sum(others) < shown["page 7"] * (MAX_ROUND_TIME / WORK + 2)


def test_a_page_that_can_t_be_shown_stops_no_other(caplog: pytest.LogCaptureFixture) -> None:
    shown = Counter[str]()

    async def go() -> None:
        rounds = Rounds(lambda _: False)
        rounds.add("broken", lambda: 1 / 0)
        rounds.add("sound", lambda: shown.update(["sound"]))
        await asyncio.sleep(0.35)
        rounds.remove("broken")
        rounds.remove("sound")
        await asyncio.sleep(0.2)
        rounds.add("late", lambda: shown.update(["late"]))
        await asyncio.sleep(0.1)
        rounds.remove("late")

    with caplog.at_level(logging.CRITICAL):
        asyncio.run(go())
    assert shown["sound"] >= 2
    assert shown["late"] >= 1, "it begins anew"


def test_what_was_asked_for_is_shown_soon() -> None:
    shown: list[float] = []

    async def go() -> float:
        rounds = Rounds(lambda _: True)
        rounds.add("page", lambda: shown.append(time.monotonic()))
        await asyncio.sleep(0.03)
        asked = time.monotonic()
        rounds.hurry()
        await asyncio.sleep(0.06)
        rounds.remove("page")
        return asked

    asked = asyncio.run(go())
    assert any(at > asked for at in shown)
