"""One page drives, and only while it hears and is heard."""

import pytest

from layflat.pages.panel import operators
from layflat.pages.panel.operators import APPEARS, FORGOTTEN, FRESH, Operators
from layflat.rig.lease import Lease


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(operators, "time", clock)
    return clock


def test_the_first_page_drives_and_others_look_on(clock: Clock) -> None:
    desk = Operators(lease := Lease())
    desk.come("a")
    desk.come("b")
    beat = desk.beat()
    assert desk.drives("a")
    assert not desk.renew("b", beat)
    assert not lease.lives
    assert desk.renew("a", beat)
    assert lease.lives
    assert desk.others == 1


def test_a_renewal_that_comes_late_or_makes_no_sense_renews_nothing(clock: Clock) -> None:
    desk = Operators(lease := Lease())
    desk.come("a")
    beat = desk.beat()
    clock.now += FRESH + 0.01
    assert not desk.renew("a", beat)
    assert not desk.renew("a", beat + 7)
    assert not lease.lives
    assert desk.renew("a", desk.beat())


def test_handing_over_is_explicit(clock: Clock) -> None:
    desk = Operators(Lease())
    desk.come("a")
    other = desk.come("b")
    assert not desk.take("b")
    assert desk.asked_by == other
    desk.hand_over("b")
    assert desk.drives("a"), "only who drives may hand over"
    desk.keep("a")
    desk.hand_over("a")
    assert desk.drives("a"), "nobody asks any more"
    desk.take("b")
    desk.hand_over("a")
    assert desk.drives("b")
    assert not desk.renew("a", desk.beat())


def test_a_silent_operator_is_none_and_another_page_may_drive(clock: Clock) -> None:
    desk = Operators(Lease())
    desk.come("a")
    desk.come("b")
    clock.now += APPEARS - 1.0
    assert desk.renew("a", desk.beat()), "a page may take its time to appear"
    clock.now += FORGOTTEN + 0.1
    assert desk.operator is None
    assert not desk.renew("a", desk.beat())
    assert desk.take("b")


def test_a_page_that_was_closed_drives_no_more(clock: Clock) -> None:
    desk = Operators(Lease())
    desk.come("a")
    desk.leave("a")
    assert desk.operator is None
    assert not desk.take("a")
    desk.come("b")
    assert desk.drives("b")


def test_a_beat_is_known_for_long_enough_however_many_pages_ask_for_one(clock: Clock) -> None:
    desk = Operators(lease := Lease())
    desk.come("a")
    beat = desk.beat()
    for _ in range(10):
        clock.now += 0.03
        for _ in range(100):
            desk.beat()
    assert desk.renew("a", beat)
    assert lease.lives


def test_who_drives_is_told_at_once(clock: Clock) -> None:
    told: list[str] = []
    desk = Operators(Lease())
    for key in "abc":
        desk.come(key, lambda key=key: told.append(key))  # type: ignore[misc]
    assert told == ["a"]
    desk.take("b")
    desk.hand_over("a")
    assert told == ["a", "b"]
    desk.leave("b")
    desk.take("c")
    assert told == ["a", "b", "c"]
