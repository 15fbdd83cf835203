"""A rig that goes comes back, is lent, and goes on with another controller."""

import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest

from layflat.errors import LayflatError
from layflat.machine import changed, load
from layflat.pages.panel.link import LinkState, RigLink
from layflat.rig.drivers import create_driver
from layflat.rig.session import STARTS_WITHIN, HostLease, RigSession
from layflat.virtual_rig import simulated_rig

pytestmark = pytest.mark.realtime
ARM = load("paper-arm")
NOBODY = "modbus://127.0.0.1:1"


def until(condition: Callable[[], bool], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture
def link(tmp_path: Path) -> Iterator[RigLink]:
    folder = tmp_path / "not" / "there"
    link = RigLink(ARM, lambda machine: (partial(simulated_rig, machine), "simulated"), folder, HostLease())
    try:
        until(lambda: link.is_at_rest, STARTS_WITHIN)
        yield link
    finally:
        link.close()


def session_of(link: RigLink) -> RigSession:
    session = link.session
    assert session is not None
    return session


def test_a_loop_that_dies_is_told_and_the_rig_comes_back_with_another_log(link: RigLink, tmp_path: Path) -> None:
    before, first = session_of(link), link.log_path
    before.process.kill()
    until(lambda: link.state is LinkState.GONE)
    assert "process is gone" in link.trouble
    assert link.snapshot() is None
    until(lambda: link.is_at_rest)
    assert link.trouble == ""
    assert link.log_path != first
    assert session_of(link) is not before


def test_a_rig_at_rest_goes_on_with_another_controller(link: RigLink) -> None:
    before = session_of(link)
    other = changed(ARM, "joint.small.gains.integral_limit", 1.0)
    link.change(other)
    until(lambda: link.session is not None and link.session is not before and link.is_at_rest)
    assert link.machine is other
    assert not before.process.is_alive()


def test_a_rig_is_lent_and_taken_back(link: RigLink) -> None:
    before = session_of(link)
    link.lend()
    assert link.state is LinkState.LENT
    assert not before.process.is_alive()
    link.reconnect()
    until(lambda: link.is_at_rest)


def test_a_rig_is_lent_to_one_at_a_time_and_changed_at_rest_only(
    link: RigLink, monkeypatch: pytest.MonkeyPatch
) -> None:
    link.lend()
    for ask in (link.lend, lambda: link.change(ARM)):
        with pytest.raises(LayflatError, match=r"has to be at rest|has the rig"):
            ask()
    link.reconnect()
    until(lambda: link.is_at_rest)
    before = session_of(link)
    monkeypatch.setattr(RigLink, "is_at_rest", False)
    for ask in (link.lend, lambda: link.change(ARM)):
        with pytest.raises(LayflatError, match="has to be at rest, without air: press Vent"):
            ask()
    assert session_of(link) is before


def test_a_rig_that_is_not_there_is_tried_again(tmp_path: Path) -> None:
    link = RigLink(ARM, lambda machine: (partial(create_driver, NOBODY, machine), NOBODY), tmp_path, HostLease())
    try:
        until(lambda: link.state is LinkState.GONE)
        assert "can't be reached" in link.trouble
    finally:
        link.close()
