"""The wire of the device in C that runs the law: what it answers, and what it passes over."""

import random
from math import nan
from typing import Any

import numpy as np
import pytest

from layflat.machine import load
from layflat.rig import frames
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import RigCommand
from layflat.rig.safety.faults import RigState
from layflat.rig.safety.requests import DeviceRequest, DeviceStatus, RequestWire, settings_digest
from layflat.rig.wire import LAW_VERSION, Identity, Wire, WireError
from tests.export.firmware.controllers import CController

ARM = load("paper-arm")
WIRE, REQUESTS = Wire.for_machine(ARM), RequestWire.for_machine(ARM)
NOTHING = [nan, nan]
IDLE = DeviceRequest(NOTHING, NOTHING, NOTHING)
CYCLE = 5000  # us
START, STOP, HOLD, RESET, AGE, SINCE, MISSED, UNRECORDED = 6, 7, 8, 9, 10, 11, 14, 15  # of the supervisor's inputs


class Device(CController):
    """Device at rest, whose host sends requests."""

    def __init__(self, library: Any) -> None:
        super().__init__(library, 2)
        middle = [WIRE.supply.count(101325.0), *[WIRE.angle.count(0.0), WIRE.pressure.count(0.0)] * 2]
        self.bench.counts, self.number = middle, 0
        self.step()

    def requested(self, request: DeviceRequest, later: int = 0) -> DeviceStatus | None:
        """Return the status that answers a request some time later, us; None where none does."""
        self.number += 1
        self.bench.time += later
        sent = self.answers(frames.REQUEST_FRAME, self.number & 0xFFFF, REQUESTS.request_bytes(request))
        return REQUESTS.status([frame.payload for frame in sent]) if sent else None


@pytest.fixture
def device(library: Any) -> Device:
    made = Device(library)
    assert made.requested(IDLE) is not None
    return made


def inputs_of(device: Device, request: DeviceRequest) -> Any:
    """Return the inputs of the next cycle, to which edges belong that came shortly before it."""
    assert device.requested(request, CYCLE // 2) is not None
    before = device.numbers("inputs")
    device.bench.time += CYCLE - CYCLE // 2
    device.step()
    after = device.numbers("inputs")
    edges = [START, STOP, HOLD, RESET, 12, 13]
    after = after.copy()
    after[edges] = before[edges]
    return after


def test_its_identity_is_that_of_a_device_that_runs_this_machine_s_law(library: Any) -> None:
    device = Device(library)
    (frame,) = device.answers(frames.IDENTIFY_FRAME, 7, b"")
    assert (frame.kind, frame.sequence) == (frames.IDENTITY_FRAME, 7)
    words = frames.unpack_words(frame.payload)
    identity = Identity.from_words(words, (LAW_VERSION,))
    assert identity.runs_law
    assert identity.digest == settings_digest(ARM)
    assert identity.check(ARM, "here").dithers
    with pytest.raises(WireError, match="the rig speaks version 2 of the protocol, layflat version 1"):
        Identity.from_words(words)


def test_a_request_reaches_the_law(device: Device) -> None:
    request = DeviceRequest([0.1, -0.2], [1.0, nan], [2.0, 3.0], age=0.01, since=0.25)
    inputs = inputs_of(device, request)
    np.testing.assert_array_equal(inputs[16:].reshape(2, 5)[:, 2:], [[0.1, 1.0, 2.0], [-0.2, nan, 3.0]])
    assert inputs[[AGE, SINCE]] == pytest.approx([0.01 + 2.5e-3, 0.25 + 2.5e-3], abs=1e-15)
    assert inputs[UNRECORDED] == 0.0
    assert inputs_of(device, request._replace(recording=False))[UNRECORDED] == 1.0


def test_every_edge_counts_once_and_the_first_request_tells_where_counts_begin(library: Any) -> None:
    device = Device(library)
    assert device.requested(IDLE._replace(edges=(3, 1, 4, 15))) is not None
    for edges, expected in (
        ((3, 1, 4, 15), []), ((4, 1, 4, 15), [START]), ((4, 1, 4, 15), []), ((4, 2, 7, 15), [STOP, HOLD]),
        ((4, 2, 7, 16), [RESET]), ((4 + 16, 2, 7, 16), []),
    ):  # fmt: skip
        inputs = inputs_of(device, IDLE._replace(edges=edges))
        assert [i for i in (START, STOP, HOLD, RESET) if inputs[i] > 0.0] == expected
    device.answers(frames.IDENTIFY_FRAME, 0, b"")
    inputs = inputs_of(device, IDLE)
    assert not inputs[[START, STOP, HOLD, RESET]].any()


def test_an_edge_is_not_lost_between_two_cycles_nor_by_a_request_that_follows(device: Device) -> None:
    device.requested(IDLE._replace(edges=(1, 0, 0, 0)), 1000)
    inputs = inputs_of(device, IDLE._replace(edges=(1, 0, 0, 0)))
    assert inputs[START] == 1.0
    status = device.requested(IDLE._replace(edges=(1, 0, 0, 0)))
    assert status is not None
    assert status.state is RigState.STARTING


def test_old_damaged_and_impossible_requests_are_passed_over(device: Device) -> None:
    wanted = IDLE._replace(edges=(1, 1, 1, 1), demands=[0.5, 0.5])
    payload, number = REQUESTS.request_bytes(wanted), device.number
    rng = random.Random(0)
    good = frames.encode(frames.REQUEST_FRAME, number + 1, payload)
    spoilt = [frames.encode(frames.REQUEST_FRAME, n & 0xFFFF, payload) for n in (number, number - 1, number + 0x8000)]
    for _ in range(300):
        at = rng.randrange(1, len(good) - 1)
        spoilt.append(good[:at] + bytes([good[at] ^ 1 << rng.randrange(8)]) + good[at + 1 :])
    wrong = (
        payload[:-8], payload + bytes(8), b"",
        REQUESTS.request_bytes(wanted._replace(age=nan)), REQUESTS.request_bytes(wanted._replace(age=-1.0)),
        REQUESTS.request_bytes(wanted._replace(since=float("inf"))), REQUESTS.request_bytes(wanted._replace(outputs=1)),
        REQUESTS.request_bytes(wanted._replace(switches=1)), payload[:4] + b"\1\0" + payload[6:],
    )  # fmt: skip
    spoilt += [frames.encode(frames.REQUEST_FRAME, number + 1, one) for one in wrong]
    for data in spoilt:
        assert device.answers_to(data) == []
    inputs = inputs_of(device, IDLE)
    assert not inputs[[START, STOP, HOLD, RESET]].any()
    assert np.isnan(inputs[[18, 23]]).all()


def test_voltages_of_a_host_that_runs_the_law_itself_are_not_obeyed(device: Device) -> None:
    driven = list(device.bench.driven)
    words = WIRE.command_words(RigCommand(np.array([9.0, 9.0]), air=True, reset=True))
    for reset in (0, 2, 0, 2):
        device.number += 1
        words[0] = 1 | reset
        assert device.answers(frames.COMMAND_FRAME, device.number, frames.pack_words(words)) == []
    assert (device.bench.on, device.bench.driven) == (False, driven)


def test_events_are_sent_until_the_host_has_them(device: Device) -> None:
    device.bench.open = True
    device.bench.time += CYCLE
    device.step()
    first = device.requested(IDLE)
    assert first is not None
    assert first.reading.stopped
    assert first.reading.device is DeviceState.DUMPED
    assert first.events[0] == (22, -1)
    again = device.requested(IDLE._replace(events=first.events_before))
    assert again is not None
    assert again.events == first.events
    read = first.events_before + len(first.events)
    none_left = device.requested(IDLE._replace(events=read))
    assert none_left is not None
    assert (none_left.events_before, none_left.events) == (read, [])


def test_cycles_that_are_left_out_are_told_to_the_supervisor(device: Device) -> None:
    for late, missed in ((CYCLE, 0.0), (CYCLE + 4000, 0.0), (3 * CYCLE, 1.0), (CYCLE, 0.0)):
        device.bench.time += late
        device.step()
        inputs = device.numbers("inputs")
        assert (inputs[MISSED], inputs[4]) == (missed, pytest.approx(1e-6 * late))
    status = device.requested(IDLE)
    assert status is not None
    assert status.cycle == 5


def test_silence_grows_old_without_end(device: Device) -> None:
    ages = []
    for _ in range(4):
        device.bench.time = (device.bench.time + (1 << 30)) & 0xFFFFFFFF
        device.step()
        ages.append(device.numbers("inputs")[AGE])
    assert all(age > ARM.safety.setpoint_age for age in ages)
    assert ages == sorted(ages)
