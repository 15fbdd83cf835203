"""What an operator asks for reaches the rig as long as the lease lives and the rig obeys, and no longer."""

import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from layflat.machine import load
from layflat.pages.panel.moves import SequenceStep
from layflat.pages.panel.pilot import Pilot
from layflat.rig.record import RowLayout
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import HostLease, RigSession, RigSnapshot

pytestmark = pytest.mark.realtime
ARM = load("paper-arm-tracking")
LAYOUT = RowLayout.for_machine(ARM)


class Rig:
    """A link and its session in one: it notes what it is told, and shows a state."""

    machine = ARM

    def __init__(self) -> None:
        self.state, self.heard, self.asked = RigState.READY, list[str](), list[Any]()
        self.session: Any = self
        self.lapsed, self.lapses, self.fault = False, 0, Fault.NONE

    def snapshot(self) -> RigSnapshot | None:
        if self.session is None:
            return None
        row = np.zeros(LAYOUT.width)
        LAYOUT.named(row, "mode")[...] = self.state
        LAYOUT.named(row, "fault")[...] = self.fault
        LAYOUT.named(row, "time")[...] = time.monotonic()
        return RigSnapshot(LAYOUT, row)

    def ask(self, angles: Any, velocities: Any = None, *_: Any, **__: Any) -> None:
        self.asked.append((np.array(angles), velocities))


@pytest.fixture(autouse=True)
def _telling(monkeypatch: pytest.MonkeyPatch) -> None:
    """A session's methods are called by their names: they note them."""
    for name in ("start", "hold", "stop", "reset"):
        monkeypatch.setattr(RigSession, name, lambda rig, name=name: rig.heard.append(name))


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def lease() -> Any:
    """One that lives until it is told to lapse."""
    return SimpleNamespace(active=True)


@pytest.fixture
def pilot(rig: Rig, lease: HostLease) -> Iterator[Pilot]:
    made = Pilot(rig, lease)  # type: ignore[arg-type]
    yield made
    made.close()


def until(condition: Callable[[], bool], seconds: float = 2.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_a_jog_moves_until_it_is_asked_for_nothing(pilot: Pilot, rig: Rig) -> None:
    pilot.jog([0.2, 0.0])
    until(lambda: bool(rig.asked) and rig.asked[-1][0][0] > 0.02)
    pilot.jog([0.0, 0.0])
    until(lambda: not any(rig.asked[-1][1]))
    time.sleep(0.1)
    count = len(rig.asked)
    time.sleep(0.1)
    assert len(rig.asked) == count, "it is over"


@pytest.mark.parametrize("lapses", [True, False], ids=["lease", "state"])
def test_a_course_ends_where_the_lease_lapses_or_the_rig_does_not_obey(
    pilot: Pilot, rig: Rig, lease: Any, lapses: bool
) -> None:
    assert pilot.start_sequence([SequenceStep((0.5, 0.5)), SequenceStep((0.0, 0.0))], repeats=True)
    until(lambda: len(rig.asked) > 3)
    if lapses:
        lease.active = False
    else:
        rig.state = RigState.FAULT
    until(lambda: pilot.sequence is None)
    count = len(rig.asked)
    assert not pilot.start_sequence([SequenceStep((0.1, 0.1))])
    time.sleep(0.1)
    assert len(rig.asked) == count


def test_stop_and_vent_end_a_course_at_once(pilot: Pilot, rig: Rig) -> None:
    for what, heard in ((pilot.hold, "hold"), (pilot.controlled_stop, "stop")):
        assert pilot.start_sequence([SequenceStep((0.5, 0.5))])
        what()
        assert pilot.sequence is None
        assert rig.heard[-1] == heard


def test_a_start_is_wished_for_until_the_lease_lives(pilot: Pilot, rig: Rig, lease: Any) -> None:
    lease.active = False
    pilot.start()
    time.sleep(0.1)
    assert rig.heard == []
    lease.active = True
    until(lambda: rig.heard == ["start"])
    lease.active = False
    pilot.start()
    pilot.hold()
    lease.active = True
    time.sleep(0.1)
    assert rig.heard == ["start", "hold"], "a stop takes the wish away"


def test_where_the_rig_is_gone_nothing_is_asked_and_the_charts_begin_anew(pilot: Pilot, rig: Rig) -> None:
    until(lambda: pilot.history.samples() is not None)
    rig.session = None
    until(lambda: pilot.history.samples() is None)
    assert not pilot.start_sequence([SequenceStep((0.1, 0.1))])
    pilot.hold()
    pilot.jog([1.0, 0.0])
    time.sleep(0.1)
    assert rig.heard == []
    assert rig.asked == []


def test_an_arm_that_was_held_by_nobody_s_wish_says_why_until_it_goes_on(pilot: Pilot, rig: Rig) -> None:
    rig.state = RigState.MOVING
    time.sleep(0.1)
    rig.lapsed, rig.lapses = True, 1
    rig.state = RigState.HOLDING
    until(lambda: "was not heard" in pilot.hold_reason)
    rig.state = RigState.STOPPED
    time.sleep(0.1)
    assert "was not heard" in pilot.hold_reason
    rig.lapsed, rig.state = False, RigState.STARTING
    until(lambda: pilot.hold_reason == "")


def test_a_fault_that_is_over_is_still_told_and_a_person_s_stop_needs_no_reason(pilot: Pilot, rig: Rig) -> None:
    rig.state, rig.fault = RigState.STOPPED, Fault.SETPOINT_STALE
    until(lambda: pilot.hold_reason == Fault.SETPOINT_STALE.title)
    rig.fault = Fault.NONE
    time.sleep(0.1)
    assert pilot.hold_reason == Fault.SETPOINT_STALE.title
    rig.state = RigState.READY
    until(lambda: pilot.hold_reason == "")
    rig.lapses = 3
    pilot.hold()
    rig.state = RigState.HOLDING
    time.sleep(0.1)
    assert pilot.hold_reason == ""
    rig.lapses = 4
    rig.state = RigState.STOPPED
    until(lambda: "was not heard" in pilot.hold_reason)
