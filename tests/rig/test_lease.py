"""A rig that nobody minds is held, then stops; whoever comes back goes on."""

import time

import pytest

from layflat.machine import load
from layflat.rig.lease import Lease
from layflat.rig.safety.states import State
from layflat.rig.session import Session
from tests.rig import fake_drivers as drivers

ARM = load("paper-arm")


def test_a_lease_begins_lapsed_and_lives_as_long_as_it_is_renewed() -> None:
    lease = Lease()
    assert lease.over
    lease.renew()
    assert lease.lives
    time.sleep(0.25)
    assert not lease.lives
    assert not lease.over


def minded(rig: Session, lease: Lease, until: State, seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while (shot := rig.snapshot()) is None or shot.state is not until:
        assert time.monotonic() < end, shot and shot.state
        lease.renew()
        time.sleep(0.05)


def since(rig: Session, begun: float, until: State) -> float:
    while (shot := rig.snapshot()) is None or shot.state is not until:
        assert time.monotonic() - begun < 5.0, shot and shot.state
        time.sleep(0.002)
    return time.monotonic() - begun


@pytest.mark.realtime
def test_a_rig_that_nobody_minds_is_held_and_stops() -> None:
    lease = Lease()
    with Session(ARM, drivers.simulated, lease=lease) as rig:
        rig.start()  # nobody is there
        begun = time.monotonic()
        while rig.snapshot() is None:
            assert time.monotonic() - begun < 10.0
            time.sleep(0.01)
        time.sleep(0.1)
        shot = rig.snapshot()
        assert shot is not None
        assert shot.state is State.OFF
        lease.renew()
        rig.start()
        minded(rig, lease, State.READY)
        rig.ask([0.5, 0.5])
        minded(rig, lease, State.MOVING)
        lease.renew()
        begun = time.monotonic()
        assert since(rig, begun, State.HOLDING) < 0.25
        rig.ask([0.5, 0.5])
        lease.renew()
        rig.start()  # somebody is back in time: what was asked for is forgotten
        minded(rig, lease, State.READY)
        begun = time.monotonic()
        assert since(rig, begun, State.STOPPED) < 1.0
        time.sleep(3.0)  # longer than the loop would wait for a host that is gone
        rig.check()
        lease.renew()
        rig.start()
        minded(rig, lease, State.READY)
