"""One page drives, and only while it hears and is heard."""

import pytest

from layflat.pages.panel import operators
from layflat.pages.panel.operators import FIRST_CONTACT_TIMEOUT, MAX_BEAT_AGE, OPERATOR_TIMEOUT, Operators
from layflat.rig.session import HostLease


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
    desk = Operators(lease := HostLease())
    desk.register("a")
    desk.register("b")
    beat = desk.beat()
    assert desk.drives("a")
    assert not desk.renew("b", beat)
    assert not lease.active
    assert desk.renew("a", beat)
    assert lease.active
    assert desk.others == 1


def test_a_renewal_that_comes_late_or_makes_no_sense_renews_nothing(clock: Clock) -> None:
    desk = Operators(lease := HostLease())
    desk.register("a")
    beat = desk.beat()
    clock.now += MAX_BEAT_AGE + 0.01
    assert not desk.renew("a", beat)
    assert not desk.renew("a", beat + 7)
    assert not lease.active
    assert desk.renew("a", desk.beat())


def test_handing_over_is_explicit(clock: Clock) -> None:
    desk = Operators(HostLease())
    desk.register("a")
    other = desk.register("b")
    assert not desk.take_control("b")
    assert desk.requested_by == other
    desk.hand_over("b")
    assert desk.drives("a"), "only who drives may hand over"
    desk.refuse_request("a")
    desk.hand_over("a")
    assert desk.drives("a"), "nobody asks any more"
    desk.take_control("b")
    desk.hand_over("a")
    assert desk.drives("b")
    assert not desk.renew("a", desk.beat())


def test_a_silent_operator_is_none_and_another_page_may_drive(clock: Clock) -> None:
    desk = Operators(HostLease())
    desk.register("a")
    desk.register("b")
    clock.now += FIRST_CONTACT_TIMEOUT - 1.0
    assert desk.renew("a", desk.beat()), "a page may take its time to appear"
    clock.now += OPERATOR_TIMEOUT + 0.1
    assert desk.operator is None
    assert not desk.renew("a", desk.beat())
    assert desk.take_control("b")


def test_a_page_that_was_closed_drives_no_more(clock: Clock) -> None:
    desk = Operators(HostLease())
    desk.register("a")
    desk.leave("a")
    assert desk.operator is None
    assert not desk.take_control("a")
    desk.register("b")
    assert desk.drives("b")


def test_a_beat_is_known_for_long_enough_however_many_pages_ask_for_one(clock: Clock) -> None:
    desk = Operators(lease := HostLease())
    desk.register("a")
    beat = desk.beat()
    for _ in range(10):
        clock.now += 0.03
        for _ in range(100):
            desk.beat()
    assert desk.renew("a", beat)
    assert lease.active


def test_who_drives_is_told_at_once(clock: Clock) -> None:
    told: list[str] = []
    desk = Operators(HostLease())
    for key in "abc":
        desk.register(key, lambda key=key: told.append(key))  # type: ignore[misc]
    assert told == ["a"]
    desk.take_control("b")
    desk.hand_over("a")
    assert told == ["a", "b"]
    desk.leave("b")
    desk.take_control("c")
    assert told == ["a", "b", "c"]
