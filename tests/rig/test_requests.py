"""Requests and statuses keep their content on the wire, and what is damaged is none."""

from math import nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat import changed, load
from layflat.rig.safety.faults import Fault, RigState, ValveMode
from layflat.rig.safety.requests import DeviceRequest, settings_digest
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.wire import WireError
from tests.rig.statuses import ARM, REQUESTS, status

numbers = st.floats(allow_nan=False, width=64)
pairs = st.lists(numbers, min_size=2, max_size=2)
bytes_ = st.integers(0, 255)


@given(
    st.builds(
        DeviceRequest,
        demands=pairs, velocities=pairs, accelerations=pairs, edges=st.tuples(*[st.integers(0, 15)] * 4),
        outputs=bytes_, switches=bytes_, recording=st.booleans(), events=st.integers(0, 0xFFFF),
        age=numbers, since=numbers,
    )
)  # fmt: skip
def test_a_request_comes_as_it_was_sent(request: DeviceRequest) -> None:
    assert REQUESTS.request(REQUESTS.request_bytes(request)) == request


def test_demands_that_are_not_there_stay_so_and_counts_go_round() -> None:
    nothing = [nan, nan]
    sent = DeviceRequest([0.1, nan], nothing, nothing, (16, 17, 33, 2))
    came = REQUESTS.request(REQUESTS.request_bytes(sent))
    np.testing.assert_array_equal([came.demands, came.velocities], [sent.demands, nothing])
    assert came.edges == (0, 1, 1, 2)


@given(
    st.sampled_from(RigState), st.sampled_from(ValveMode), st.booleans(), bytes_, st.sampled_from(Fault),
    st.lists(st.tuples(bytes_, st.integers(-1, 6)), max_size=40),
)  # fmt: skip
def test_a_status_comes_as_it_was_sent(
    state: RigState, mode: ValveMode, vented: bool, outputs: int, fault: Fault, events: list[tuple[int, int]]
) -> None:
    sent = status(
        state=state, mode=mode, vented=vented, outputs=outputs, fault=fault, joint_faults=[fault, Fault.NONE],
        events_before=65530, events=events,
    )  # fmt: skip
    came = REQUESTS.status(REQUESTS.status_bytes(sent))
    assert came[1:-1] == sent[1:-1]
    assert came.reading.supply == sent.reading.supply
    np.testing.assert_array_equal(came.reading.angles, sent.reading.angles)
    np.testing.assert_array_equal(came.signals, sent.signals)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda parts: [parts[0][:-1], *parts[1:]],
        lambda parts: [parts[0] + b"\1", *parts[1:]],
        lambda parts: [parts[0], parts[2], parts[1]],
        lambda parts: parts[:2],
        lambda parts: [parts[0], parts[1], parts[2][:-4]],
        lambda parts: [parts[0][:12] + b"\x09" + parts[0][13:], *parts[1:]],
        lambda parts: [b"", *parts[1:]],
    ],
)
def test_what_is_not_whole_is_no_status(spoil: object) -> None:
    parts = REQUESTS.status_bytes(status())
    assert REQUESTS.status(parts).cycle == 7
    with pytest.raises(WireError):
        REQUESTS.status(spoil(parts))  # type: ignore[operator]
    with pytest.raises(WireError):
        REQUESTS.request(bytes(10))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("arm.payload", 1.4),
        ("safety.hold_time", 0.4),
        ("joint.small.gains.near.error", 80.0),
        ("controller.cycle", 4e-3),
    ],
)
def test_another_machine_has_another_digest(path: str, value: float) -> None:
    assert settings_digest(ARM) == settings_digest(load("paper-arm"))
    assert settings_digest(changed(ARM, path, value)) != settings_digest(ARM)
    assert settings_digest(ARM) != settings_digest(load("paper-arm-tracking"))


def test_edges_are_counted_outputs_switched_and_demands_replaced() -> None:
    first = DeviceRequest.first(2)
    moved = first.following(
        HostRequest([0.1, nan], start=True, switched=[(1, True), (0, False)], age=0.02, since=0.01),
        recording=True, events=3,
    )  # fmt: skip
    assert moved.edges == (1, 0, 0, 0)
    assert (moved.outputs, moved.switches, moved.events, moved.age, moved.since) == (0b10, 0b11, 3, 0.02, 0.01)
    assert moved.demands[0] == 0.1
    assert np.isnan([*moved.velocities, *moved.accelerations]).all()
    ended = moved.following(
        HostRequest([0.2, 0.3], stop=True, reset=True, hold=True, velocities=[1.0, 2.0], switched=[(1, False)]),
        recording=False, events=4,
    )  # fmt: skip
    assert ended.edges == (1, 1, 1, 1)
    assert (ended.outputs, ended.switches, ended.recording, ended.age) == (0, 0b01, False, 0.0)
    assert list(ended.velocities) == [1.0, 2.0]
