"""The supervisor of a device that runs the law itself: it forwards requests, and mirrors what the device reports."""

from math import nan

import numpy as np
import pytest

from layflat.rig.driver import SensorReading
from layflat.rig.safety.faults import Fault, RigState, ValveMode
from layflat.rig.safety.remote import RemoteSupervisor
from layflat.rig.safety.requests import DeviceRequest, DeviceStatus
from layflat.rig.safety.supervisor import HostRequest
from tests.rig.statuses import ARM, status

NOTHING = [nan, nan]
IDLE = HostRequest(NOTHING)


class Device:
    """Device that keeps requests."""

    def __init__(self) -> None:
        self.status: DeviceStatus | None = None
        self.requests: list[DeviceRequest] = []

    def request(self, request: DeviceRequest) -> None:
        self.requests.append(request)


class Remote:
    """Supervisor of a device; a cycle takes 5 ms."""

    def __init__(self) -> None:
        self.device = Device()
        self.supervisor = RemoteSupervisor(ARM, self.device)

    def cycle(self, reply: DeviceStatus | None, request: HostRequest = IDLE) -> DeviceRequest:
        """Return the request that it sends."""
        reading: SensorReading | None = None
        if reply is not None:
            self.device.status, reading = reply, reply.reading
        self.supervisor.cycle(reading, request, 5e-3, 5e-3)
        return self.device.requests[-1]

    def events(self) -> list[str]:
        """Return the events since the last call."""
        events = self.supervisor.ledger.events[:]
        self.supervisor.ledger.events.clear()
        return events


@pytest.fixture
def remote() -> Remote:
    made = Remote()
    made.cycle(status())
    return made


def test_every_request_of_the_host_counts_once(remote: Remote) -> None:
    for k in (1, 2):
        assert remote.cycle(status(), IDLE._replace(start=True)).edges == (k, k - 1, 0, 0)
        assert remote.cycle(status()).edges == (k, k - 1, 0, 0)
        assert remote.cycle(status(), IDLE._replace(stop=True)).edges == (k, k, 0, 0)
    assert remote.cycle(status(), IDLE._replace(hold=True, reset=True)).edges == (2, 2, 1, 1)


def test_demands_outputs_and_ages_go_to_the_device(remote: Remote) -> None:
    host = HostRequest([0.1, nan], age=0.02, velocities=[1.0, 2.0], since=0.03, switched=[(0, True), (2, True)])
    sent = remote.cycle(status(), host)
    np.testing.assert_array_equal(sent.demands, [0.1, nan])
    np.testing.assert_array_equal(sent.accelerations, NOTHING)
    assert (sent.velocities, sent.age, sent.since) == ([1.0, 2.0], 0.02, 0.03)
    assert (sent.outputs, sent.switches, sent.recording) == (0b101, 0b101, True)
    remote.supervisor.recording = False
    sent = remote.cycle(status(), IDLE._replace(switched=[(0, False), (1, True)]))
    assert (sent.outputs, sent.switches, sent.recording) == (0b110, 0b110, False)


def test_it_shows_what_the_device_reports(remote: Remote) -> None:
    supervisor = remote.supervisor
    rows = np.zeros((2, 15))
    remote.cycle(status(fault=Fault.OVER_SPEED, joint_faults=[Fault.NONE, Fault.OVER_SPEED], outputs=2))
    assert (supervisor.state, supervisor.is_pressurised, supervisor.is_vented) == (RigState.MOVING, True, False)
    assert (supervisor.fault, supervisor.ledger.joints[1]) == (Fault.OVER_SPEED, Fault.OVER_SPEED)
    assert supervisor.outputs == 2
    supervisor.record(rows)
    reading = status().reading
    np.testing.assert_array_equal(rows[:, 3:5], np.column_stack([reading.angles, reading.pressures]))
    np.testing.assert_array_equal(rows[:, 5:14], status().signals[:, 5:])
    np.testing.assert_array_equal(rows[:, 14], [0, Fault.OVER_SPEED])
    remote.cycle(status(state=RigState.STOPPED, mode=ValveMode.VENT, vented=True))
    assert (supervisor.state, supervisor.is_pressurised, supervisor.is_vented) == (RigState.STOPPED, False, True)


def test_events_come_once_though_replies_are_lost(remote: Remote) -> None:
    events: list[tuple[int, int]] = [(32 + RigState.HOLDING, -1), (int(Fault.OVER_SPEED), 1)]
    assert remote.cycle(status(events=events[:1])).events == 1
    assert remote.events() == ["moving -> holding"]
    held = status(state=RigState.HOLDING, events=events)
    assert remote.cycle(held).events == 2
    assert remote.events() == ["joint 'small': over-speed"]
    assert remote.cycle(held).events == 2
    fault = held._replace(state=RigState.FAULT, events_before=1, events=[events[1], (32 + RigState.FAULT, -1)])
    assert remote.cycle(fault).events == 3
    assert remote.events() == ["holding -> fault"]


def test_events_before_the_first_status_are_those_of_others() -> None:
    remote = Remote()
    assert remote.cycle(status(events_before=65535, events=[(22, -1), (20, 0)])).events == 1
    assert remote.events() == []


def test_a_lost_link_is_a_fault_until_a_reset_and_stops_the_device(remote: Remote) -> None:
    supervisor = remote.supervisor
    for k in range(1, 4):
        remote.cycle(None)
        assert supervisor.lost == k
    assert (supervisor.fault, supervisor.state) == (Fault.LINK_LOST, RigState.FAULT)
    assert remote.events() == ["a reply was lost", "link lost"]
    assert remote.cycle(status()).edges == (0, 2, 0, 0)
    assert (supervisor.fault, supervisor.state) == (Fault.LINK_LOST, RigState.FAULT)
    assert remote.cycle(status(), IDLE._replace(start=True)).edges[0] == 0
    assert remote.events() == ["no start: a fault is latched; give a reset first"]
    remote.cycle(status(state=RigState.STOPPED), IDLE._replace(reset=True))
    assert (supervisor.fault, supervisor.state) == (Fault.NONE, RigState.STOPPED)
    assert remote.cycle(status(), IDLE._replace(start=True)).edges[0] == 1


def test_a_device_that_stays_silent_counts_as_vented_in_the_end(remote: Remote) -> None:
    supervisor = remote.supervisor
    silent = 0.0
    while not supervisor.is_vented:
        remote.cycle(None)
        silent += 5e-3
    assert silent == pytest.approx(0.1 + ARM.safety.hold_time + 0.3 + ARM.safety.vent_time, abs=0.02)


def test_cycles_that_the_loop_misses_are_its_own_fault(remote: Remote) -> None:
    remote.supervisor.missed = True
    remote.cycle(status())
    assert remote.supervisor.fault is Fault.CYCLE_MISSED
    assert remote.events() == [Fault.CYCLE_MISSED.title]
