"""A rig that runs, as a viewer sees it: rows of its loop, changes of state, faults."""

from collections.abc import Callable

import numpy as np
import pytest

from layflat.foxglove.rig import RigServer
from layflat.machine import load
from layflat.rig.record import SHARED_COLUMNS, RowLayout
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import RigSnapshot
from tests.foxglove.messages import Viewer, positions

ARM = load("paper-arm")
LAYOUT = RowLayout.for_machine(ARM)
WALL = 1_780_000_000.0  # time of day at the start, s since 1970


def cycle(
    time: float, state: RigState = RigState.MOVING, fault: Fault = Fault.NONE, layout: RowLayout = LAYOUT
) -> RigSnapshot:
    row = np.random.default_rng(round(1e3 * time)).uniform(-1.0, 1.0, layout.width)
    shot = RigSnapshot(layout, row)
    for name, value in {"time": time, "wall": WALL + time, "mode": state, "fault": fault}.items():
        row[layout.shared[name]] = value
    layout.named(row, "joint_fault")[:] = 0.0, fault
    return shot


class Rig:
    """Source of cycles; the last one stays until the next is shown."""

    def __init__(self) -> None:
        self.shot: RigSnapshot | None = None

    def __call__(self) -> RigSnapshot | None:
        if self.shot is None:
            raise ValueError("the memory is closed")
        return self.shot


def shown(viewer: Viewer, rig: Rig, shot: RigSnapshot) -> None:
    rig.shot = shot
    time = float(shot["time"])
    viewer.receive(lambda: viewer.topics["/machine"] and viewer.topics["/machine"][-1][1]["time"] == time)


def connected(rig: Rig, viewer: Viewer, layout: RowLayout = LAYOUT) -> None:
    """Show cycles until one arrives on every topic: the first may be sent before the viewer has subscribed."""
    time = iter(np.arange(0.0, 10.0, 0.125).tolist())
    viewer.topics.clear()

    def arrived() -> bool:
        rig.shot = cycle(next(time), layout=layout)
        return {"/joint_states", "/tf", "/machine", "/joint/large", "/joint/small"} <= set(viewer.topics)

    viewer.receive(arrived)


def test_rows_are_shown_with_their_numbers_and_times() -> None:
    rig = Rig()
    with RigServer(ARM, port=0) as server, Viewer(server.address) as viewer:
        server.follow(rig)
        connected(rig, viewer)
        shot = cycle(20.005)
        shown(viewer, rig, shot)
    stamp, machine = viewer.topics["/machine"][-1]
    assert stamp == round(WALL * 1e9) + 20_005_000_000
    assert machine == {name: float(shot[name]) for name in SHARED_COLUMNS}
    assert positions(viewer.topics["/joint_states"])[-1] == shot["measured_angle"].tolist()
    _, joint = viewer.topics["/joint/small"][-1]
    assert joint == {name: float(shot[name][1]) for name in LAYOUT.by_joint}
    assert [one.child_frame_id for one in viewer.topics["/tf"][-1][1].transforms][-1] == "tool"
    assert viewer.topics["/scene"]
    assert "playbackControl" not in viewer.info["capabilities"]
    assert not {"clientPublish", "services", "parameters"} & set(viewer.info["capabilities"])


def test_changes_of_state_and_faults_are_events() -> None:
    rig = Rig()
    with RigServer(ARM, port=0) as server, Viewer(server.address) as viewer:
        server.follow(rig)
        connected(rig, viewer)
        shown(viewer, rig, cycle(20.0, RigState.FAULT, Fault.ANGLE_FROZEN))
        shown(viewer, rig, cycle(20.5, RigState.OFF))
        viewer.receive(lambda: viewer.topics["/events"][-1][1].message == "no fault any more")
    events = [(one.level, one.message) for _, one in viewer.topics["/events"]]
    assert events[-4:] == [
        (2, "moving -> fault"),
        (4, f"joint 'small': {Fault.ANGLE_FROZEN.title}"),
        (2, "fault -> off"),
        (2, "no fault any more"),
    ]


def test_another_controller_and_another_loop_are_followed() -> None:
    rig, other = Rig(), RowLayout(LAYOUT.joints, (("guess", ("rad", "of another law")),))
    with RigServer(ARM, port=0) as server, Viewer(server.address) as viewer:
        server.follow(rig)
        connected(rig, viewer)
        shown(viewer, rig, cycle(20.0))
        connected(rig, viewer, other)
        shown(viewer, rig, cycle(20.5, layout=other))
    stamp, joint = viewer.topics["/joint/large"][-1]
    assert "guess" in joint
    assert stamp == round(WALL * 1e9) + 20_500_000_000


@pytest.mark.parametrize("source", [lambda: None, Rig()])
def test_without_a_cycle_nothing_is_sent(source: Callable[[], RigSnapshot | None]) -> None:
    with RigServer(ARM, port=0) as server, Viewer(server.address) as viewer:
        server.follow(source)
        with pytest.raises(TimeoutError):
            viewer.receive(lambda: False, seconds=0.3)
        assert not any(viewer.topics.values())
