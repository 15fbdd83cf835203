"""Playback to a viewer that speaks Foxglove's protocol: the same numbers, at any speed, under the viewer's control."""

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

import numpy as np
import pytest
import xarray
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.foxglove.playback import Playback, PlaybackClock
from layflat.machine import load
from tests.foxglove.messages import Viewer, positions

ARM = load("paper-arm")
ANGLES = np.linspace([0.0, 0.1], [0.5, -0.3], 401)
END = 2_000_000_000  # of LOG, ns
LOG = xarray.Dataset(
    {"angle": (("time", "joint"), ANGLES), "pressure_a": (("time", "joint"), 1e5 + 1e5 * ANGLES)},
    {"time": np.linspace(0.0, 2.0, 401), "joint": list(ARM.joints)},
    {"machine": ARM.model_dump_json(), "machine_name": "paper-arm"},
).assign(event_time=("event", [1.0]), event_level=("event", [40]), event_text=("event", ["e-stop"]))


@contextmanager
def serving(playback: Playback) -> Iterator[Playback]:
    over = Event()
    with playback:
        thread = Thread(target=playback.serve, args=(over.is_set,))
        thread.start()
        try:
            yield playback
        finally:
            over.set()
            thread.join()


def ended(viewer: Viewer) -> Callable[[], bool]:
    """Whether all of a playback has arrived; states overtake rows that wait to be sent."""
    names = ("/joint_states", "/tf", "/joint/large", "/joint/small")

    def arrived() -> bool:
        rows = [viewer.topics[name][-1:] for name in names]
        whole = all(row and row[0][0] == END for row in rows) and viewer.time == END
        return whole and viewer.states[-1][0] == "ended"

    return arrived


@pytest.mark.parametrize("speed", [1.0, 5.0])
def test_a_viewer_gets_all_rows_at_the_speed(speed: float) -> None:
    with serving(Playback(LOG, speed=speed, port=0)) as playback, Viewer(playback.address) as viewer:
        assert playback.shows_arm
        viewer.receive(lambda: viewer.states)
        begun = time.monotonic()
        viewer.receive(ended(viewer))
        assert time.monotonic() - begun > 0.9 * 2.0 / speed
    assert viewer.info["name"] == "paper-arm"
    assert {"time", "playbackControl"} <= set(viewer.info["capabilities"])
    assert viewer.info["dataEndTime"] == {"sec": 2, "nsec": 0}
    assert positions(viewer.topics["/joint_states"]) == ANGLES.tolist()
    pressures = [message["pressure_a"] for _, message in viewer.topics["/joint/small"]]
    assert pressures == LOG["pressure_a"][:, 1].values.tolist()
    assert [stamp for stamp, _ in viewer.topics["/tf"]] == np.rint(LOG["time"].values * 1e9).astype(int).tolist()
    assert [(stamp, one.message) for stamp, one in viewer.topics["/events"]] == [(END // 2, "e-stop")]
    assert [entity.id for entity in viewer.topics["/scene"][0][1].entities][-1] == "tool"
    assert viewer.time == END
    assert viewer.states[-1][1:3] == (END, speed)


def test_great_speeds_leave_rows_out_but_never_the_last() -> None:
    with serving(Playback(LOG, speed=40.0, port=0)) as playback, Viewer(playback.address) as viewer:
        viewer.receive(ended(viewer))
    shown = positions(viewer.topics["/joint_states"])
    assert len(shown) < 250
    assert shown[-1] == ANGLES[-1].tolist()
    assert all(row in ANGLES.tolist() for row in shown)


def test_events_come_before_the_rows_after_them() -> None:
    with serving(Playback(LOG, speed=1e4, port=0)) as playback, Viewer(playback.address) as viewer:
        viewer.receive(lambda: viewer.topics["/joint_states"] and viewer.topics["/joint_states"][-1][0] == END)
        assert [stamp for stamp, _ in viewer.topics["/events"]] == [END // 2]


def test_viewers_pause_seek_and_play_anew() -> None:
    with serving(Playback(LOG, speed=0.5, port=0)) as playback, Viewer(playback.address) as viewer:
        viewer.receive(lambda: viewer.topics["/joint_states"])
        viewer.control(play=False, speed=0.5, seek=END // 2, number="one")
        viewer.receive(lambda: viewer.topics["/joint_states"] and viewer.topics["/joint_states"][-1][0] == END // 2)
        assert ("paused", END // 2, 0.5, "one") in viewer.states
        assert positions(viewer.topics["/joint_states"])[-1] == ANGLES[200].tolist()
        viewer.control(play=True, speed=8.0, seek=None, number="two")
        viewer.receive(ended(viewer))
        count = len(viewer.topics["/joint_states"])
        viewer.control(play=True, speed=8.0, seek=None, number="three")
        viewer.receive(
            lambda: viewer.topics["/joint_states"][-1][0] == END and len(viewer.topics["/joint_states"]) > count
        )
        assert viewer.topics["/joint_states"][count][0] == 0


def test_a_second_viewer_is_sent_the_scene_too() -> None:
    with serving(Playback(LOG, port=0)) as playback, Viewer(playback.address) as first:
        first.receive(lambda: first.topics["/scene"])
        with Viewer(playback.address) as second:
            second.receive(lambda: second.topics["/scene"])
            sent = [viewer.topics["/scene"][0][1].SerializeToString() for viewer in (first, second)]
            assert sent[0] == sent[1]


@given(
    st.floats(0.01, 100.0),
    st.lists(st.tuples(st.integers(0, 10**9), st.booleans(), st.none() | st.integers(-5, 2 * END)), max_size=8),
)
def test_a_clock_stays_between_its_ends(speed: float, changes: list[tuple[int, bool, int | None]]) -> None:
    now = 0
    clock = PlaybackClock(0, END, speed, now=lambda: now)
    for passed, playing, stamp in changes:
        before, (name, _, _) = clock.read()[0], clock.state()
        now += passed
        after = clock.read()[0]
        assert (
            after == (min(before + round(passed * speed), END) if name == "Playing" else before)
            or abs(after - before - passed * speed) <= 1.0
        )
        assert 0 <= after <= END
        clock.change(playing=playing, stamp=stamp)
        if stamp is not None:
            assert clock.read() == (min(max(stamp, 0), END),) * 2


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_a_speed_that_is_none_is_refused(speed: float) -> None:
    with pytest.raises(InputError, match=r"speed: .* is not a speed; give a number above 0"):
        Playback(LOG, speed=speed, port=0)


def test_a_port_in_use_and_a_foreign_host_are_named() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"port: port {port} can't be had .Address already in use.; give another"):
            Playback(LOG, port=port)
    with pytest.raises(InputError, match=r"host: '192.0.2.1' can't be had .*; give an address of this computer"):
        Playback(LOG, host="192.0.2.1", port=0)


def test_viewers_of_this_computer_alone_reach_it() -> None:
    with Playback(LOG, port=0) as playback, socket.socket() as other:
        assert other.connect_ex(("127.0.0.2", int(playback.address.rpartition(":")[2]))) != 0
