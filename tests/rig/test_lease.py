"""A rig that nobody minds is held, then stops; whoever comes back goes on."""

import time

import pytest

from layflat.machine import load
from layflat.rig.safety.faults import RigState
from layflat.rig.session import HostLease, RigSession
from tests.rig import fake_drivers as drivers

ARM = load("paper-arm")


def test_a_lease_begins_lapsed_and_lives_as_long_as_it_is_renewed() -> None:
    lease = HostLease()
    assert lease.expired
    lease.renew()
    assert lease.active
    time.sleep(0.25)
    assert not lease.active
    assert not lease.expired


def minded(rig: RigSession, lease: HostLease, until: RigState, seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while (shot := rig.snapshot()) is None or shot.state is not until:
        assert time.monotonic() < end, shot and shot.state
        lease.renew()
        time.sleep(0.05)


def since(rig: RigSession, begun: float, until: RigState) -> float:
    while (shot := rig.snapshot()) is None or shot.state is not until:
        assert time.monotonic() - begun < 5.0, shot and shot.state
        time.sleep(0.002)
    return time.monotonic() - begun


@pytest.mark.realtime
def test_a_rig_that_nobody_minds_is_held_and_stops() -> None:
    lease = HostLease()
    with RigSession(ARM, drivers.simulated, lease=lease) as rig:
        rig.start()  # nobody is there
        begun = time.monotonic()
        while rig.snapshot() is None:
            assert time.monotonic() - begun < 10.0
            time.sleep(0.01)
        time.sleep(0.1)
        shot = rig.snapshot()
        assert shot is not None
        assert shot.state is RigState.OFF
        lease.renew()
        rig.start()
        minded(rig, lease, RigState.READY)
        rig.ask([0.5, 0.5])
        minded(rig, lease, RigState.MOVING)
        lease.renew()
        begun = time.monotonic()
        assert since(rig, begun, RigState.HOLDING) < 0.25
        rig.ask([0.5, 0.5])
        lease.renew()
        rig.start()  # somebody is back in time: what was asked for is forgotten
        minded(rig, lease, RigState.READY)
        begun = time.monotonic()
        assert since(rig, begun, RigState.STOPPED) < 1.0
        time.sleep(3.0)  # longer than the loop would wait for a host that is gone
        rig.check()
        lease.renew()
        rig.start()
        minded(rig, lease, RigState.READY)
