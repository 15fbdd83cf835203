"""The node between a session and a server: topics, goals, services, commands, and a link that is lost."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread
from typing import Any, cast

import numpy as np
import pytest

from fake_session import ARM, WALL, FakeSession
from layflat.errors import InputError
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import RigLoopError, RigSession
from layflat_ros2 import RigNode, Rosbridge
from layflat_ros2.messages import stamp
from protocol_server import Peer, ProtocolServer
from test_trajectory import goal_of

pytestmark = pytest.mark.realtime
ACTION = "/layflat/follow_joint_trajectory"
STATES, PRESSURES, COMMANDS = "/layflat/joint_states", "/layflat/pressures", "/layflat/joint_commands"
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6  # of action_msgs/msg/GoalStatus, from its documentation
FAR = goal_of([[0.5, -0.5]], [5.0])


class Bench:
    """A node that runs, its session, and a peer of the same server."""

    def __init__(self, server: ProtocolServer, session: FakeSession, lines: list[str], peer: Peer) -> None:
        self.server, self.session, self.lines, self.peer = server, session, lines, peer


@contextmanager
def running(session: FakeSession | None = None) -> Iterator[Bench]:
    session, lines, over = session or FakeSession(), list[str](), Event()
    with ProtocolServer() as server, Rosbridge(server.address) as link:
        node = RigNode(ARM, cast(RigSession, session), link, rate=100.0, hardware="bench", report=lines.append)
        thread = Thread(target=node.run, args=(over.is_set,))
        thread.start()
        try:
            with Peer(server.address) as peer:
                peer.wait(lambda: len(server.types) == 8)
                yield Bench(server, session, lines, peer)
        finally:
            over.set()
            thread.join()


@pytest.fixture
def bench() -> Iterator[Bench]:
    with running() as bench:
        yield bench


def test_names_have_the_types_of_ros(bench: Bench) -> None:
    assert bench.server.types == {
        STATES: "sensor_msgs/msg/JointState",
        PRESSURES: "control_msgs/msg/DynamicJointState",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
        ACTION: "control_msgs/action/FollowJointTrajectory",
        **{f"/layflat/{name}": "std_srvs/srv/Trigger" for name in ("start", "hold", "stop", "reset")},
    }


def test_states_and_pressures_have_the_numbers_of_the_cycle(bench: Bench) -> None:
    bench.session.demand = np.array([0.1, -0.2])
    peer = bench.peer.subscribe(STATES, PRESSURES)
    peer.wait(lambda: peer.messages(STATES) and peer.messages(PRESSURES))
    state, pressure = peer.messages(STATES)[-1], peer.messages(PRESSURES)[-1]
    shot = bench.session.snapshot()
    assert state["header"] == {"stamp": stamp(WALL), "frame_id": ""}
    assert (state["name"], state["position"]) == (["large", "small"], [0.1, -0.2])
    assert state["velocity"] == shot["averaged_velocity"].tolist()
    assert pressure["joint_names"] == ["large", "small"]
    assert [one["interface_names"] for one in pressure["interface_values"]] == [
        ["differential_pressure", "voltage"]
    ] * 2
    values = np.transpose([one["values"] for one in pressure["interface_values"]]).tolist()
    assert values == [shot["averaged_pressure"].tolist(), shot["voltage"].tolist()]


def test_states_come_at_the_rate(bench: Bench) -> None:
    peer = bench.peer.subscribe(STATES)
    peer.wait(lambda: len(peer.messages(STATES)) > 5)
    begin, count = time.monotonic(), len(peer.messages(STATES))
    peer.wait(lambda: time.monotonic() > begin + 1.0)
    assert 40 < len(peer.messages(STATES)) - count < 110


def test_a_loop_that_stands_still_is_not_published_anew(bench: Bench) -> None:
    bench.session.is_frozen = True
    peer = bench.peer.subscribe(STATES, "/diagnostics")
    peer.wait(lambda: peer.messages("/diagnostics") and peer.messages("/diagnostics")[-1]["status"][0]["level"] == 3)
    assert peer.messages("/diagnostics")[-1]["status"][0]["message"].startswith("no cycle for ")
    assert len(peer.messages(STATES)) < 3


def test_diagnostics_have_the_fault_and_its_joint(bench: Bench) -> None:
    peer = bench.peer.subscribe("/diagnostics")
    bench.session.state, bench.session.fault = RigState.FAULT, Fault.ANGLE_FROZEN
    peer.wait(lambda: peer.messages("/diagnostics") and peer.messages("/diagnostics")[-1]["status"][0]["level"] == 2)
    rig, joint = peer.messages("/diagnostics")[-1]["status"]
    assert rig["name"] == "layflat: paper-arm"
    assert rig["message"] == f"fault: joint 'small': {Fault.ANGLE_FROZEN.title}"
    assert rig["hardware_id"] == "bench"
    assert {"key": "supply [Pa]", "value": "700000"} in rig["values"]
    assert (joint["name"], joint["message"]) == ("layflat: paper-arm: small", Fault.ANGLE_FROZEN.title)
    bench.session.state, bench.session.fault = RigState.MOVING, Fault.DEMAND_LIMITED
    peer.wait(lambda: peer.messages("/diagnostics")[-1]["status"][0]["level"] == 1)


def test_a_goal_is_followed_to_its_end(bench: Bench) -> None:
    goal = bench.peer.send_goal(ACTION, goal_of([[0.2, -0.1], [0.3, 0.0]], [0.3, 0.6]))
    assert bench.peer.result(goal) == {"error_code": 0, "error_string": "", "status": SUCCEEDED}
    angles = np.array([angles for angles, _ in bench.session.asked])
    assert angles[-1] == pytest.approx([0.3, 0.0], abs=1e-12)
    assert bench.session.asked[-1][1] == [0.0, 0.0]
    assert np.abs(np.diff(angles, axis=0)).max() < 0.1
    feedback = bench.peer.feedback(goal)
    assert len(feedback) > 3
    assert all(one["joint_names"] == ["large", "small"] for one in feedback)
    for one in feedback:
        error = np.subtract(one["desired"]["positions"], one["actual"]["positions"])
        assert one["error"]["positions"] == pytest.approx(error)


def test_a_goal_begins_at_its_stamp(bench: Bench) -> None:
    goal = goal_of([[0.2, 0.0]], [0.1])
    goal["trajectory"]["header"] = {"stamp": stamp(time.time() + 0.4)}
    begin = time.monotonic()
    assert bench.peer.result(bench.peer.send_goal(ACTION, goal))["status"] == SUCCEEDED
    assert time.monotonic() - begin > 0.45


def test_a_canceled_goal_demands_no_more(bench: Bench) -> None:
    goal = bench.peer.send_goal(ACTION, FAR)
    bench.peer.wait(lambda: bench.peer.feedback(goal))
    bench.peer.send("cancel_action_goal", id=goal, action=ACTION)
    assert bench.peer.result(goal)["status"] == CANCELED
    count = len(bench.session.asked)
    time.sleep(0.1)
    assert len(bench.session.asked) == count


def test_a_second_goal_takes_the_place_of_the_first(bench: Bench) -> None:
    first = bench.peer.send_goal(ACTION, FAR)
    bench.peer.wait(lambda: bench.peer.feedback(first))
    second = bench.peer.send_goal(ACTION, goal_of([[0.1, 0.0]], [0.3]))
    assert bench.peer.result(first)["status"] == CANCELED
    assert bench.peer.result(second)["status"] == SUCCEEDED


def test_a_joint_that_lags_breaks_its_tolerances() -> None:
    session = FakeSession()
    session.lag = np.array([0.0, 0.1])
    with running(session) as bench:
        on_way, end = goal_of([[0.2, 0.0]], [3.0]), goal_of([[0.2, 0.0]], [0.1])
        on_way["path_tolerance"] = [{"name": "small", "position": 0.05}]
        end["goal_time_tolerance"] = stamp(0.2)
        texts = {
            -4: "joint 'small' is 5.73 deg off, more than 2.86 deg",
            -5: "joint 'small' is 5.73 deg off, more than 1 deg",
        }
        for goal, code in ((on_way, -4), (end, -5)):
            result = bench.peer.result(bench.peer.send_goal(ACTION, goal))
            assert result == {"error_code": code, "error_string": texts[code], "status": ABORTED}
        assert bench.lines == [f"goal: {text}" for text in texts.values()]


def test_a_fault_ends_a_goal(bench: Bench) -> None:
    goal = bench.peer.send_goal(ACTION, FAR)
    bench.peer.wait(lambda: bench.peer.feedback(goal))
    bench.session.fault = Fault.SUPPLY_LOST
    bench.session.ask = lambda *_, **__: None  # type: ignore[method-assign]
    bench.session.state = RigState.FAULT
    result = bench.peer.result(goal)
    assert result["status"] == ABORTED
    assert result["error_string"] == "the rig's state is fault: joint 'small': supply lost"


@pytest.mark.parametrize("state", [RigState.OFF, RigState.STARTING, RigState.HOLDING, RigState.STOPPED])
def test_a_rig_that_does_not_obey_refuses_goals(state: RigState) -> None:
    with running(FakeSession(state)) as bench:
        result = bench.peer.result(bench.peer.send_goal(ACTION, FAR))
        expected = f"the rig's state is {state.name.lower()}; call the service start, and wait until it is ready"
        assert result == {"error_code": -1, "error_string": expected, "status": ABORTED}
        bench.peer.send("publish", topic=COMMANDS, msg={"name": ["large", "small"], "position": [0.1, 0.1]})
        time.sleep(0.1)
        assert bench.session.asked == []


def test_services_are_requests_of_the_session(bench: Bench) -> None:
    for name in ("start", "hold", "stop", "reset"):
        reply = bench.peer.call(f"/layflat/{name}")
        assert reply == {"success": True, "message": f"{name} requested; /diagnostics has the state"}
    assert bench.session.requests == ["start", "hold", "stop", "reset"]
    bench.session.state, bench.session.fault = RigState.FAULT, Fault.NO_AIR
    reply = bench.peer.call("/layflat/start")
    assert reply["success"] is False
    assert reply["message"].endswith("call the service reset once it is over")


def test_commands_are_demands(bench: Bench) -> None:
    command = {"name": ["small", "large"], "position": [0.2, 0.1], "velocity": [0.0, 0.5]}
    bench.peer.send("publish", topic=COMMANDS, msg=command)
    bench.peer.wait(lambda: bench.session.asked)
    bench.peer.send("publish", topic=COMMANDS, msg=command | {"velocity": [None, 0.5]})
    bench.peer.wait(lambda: len(bench.session.asked) == 2)
    assert bench.session.asked == [([0.1, 0.2], [0.5, 0.0]), ([0.1, 0.2], None)]


def test_wrong_commands_are_reported_once(bench: Bench) -> None:
    for command in ({"name": ["large"], "position": [0.1]}, {"name": ["large", "small"], "position": []}, 3, None):
        bench.peer.send("publish", topic=COMMANDS, msg=command)
    bench.peer.wait(lambda: bench.lines)
    time.sleep(0.1)
    assert bench.lines == [f"{COMMANDS}: joint command: 1 positions of large; give a position of each of large, small"]
    assert bench.session.asked == []


def test_commands_wait_for_a_goal(bench: Bench) -> None:
    goal = bench.peer.send_goal(ACTION, FAR)
    bench.peer.wait(lambda: bench.peer.feedback(goal))
    bench.peer.send("publish", topic=COMMANDS, msg={"name": ["large", "small"], "position": [-0.5, 0.5]})
    time.sleep(0.1)
    assert all(angles[0] > -0.1 for angles, _ in bench.session.asked)


def test_nonsense_of_a_server_is_ignored(bench: Bench) -> None:
    for client in bench.server.clients:
        for text in ("no JSON", "[]", "{}", '{"op": 3}', '{"op": "fly"}', '{"op": "call_service"}', b"\x00\xff"):
            client.send(text)
    assert bench.peer.send("subscribe", topic=STATES)
    status = '{"op": "status", "level": "error", "msg": "Unable to load control_msgs"}'
    for client in bench.server.clients:
        client.send(status)
    time.sleep(0.1)
    assert bench.lines == ["rosbridge: Unable to load control_msgs"]


def test_a_lost_link_ends_the_goal_and_comes_back() -> None:
    session, lines, over = FakeSession(), list[str](), Event()
    with ProtocolServer() as first:
        port = first.port
        link = Rosbridge(first.address)
        node = RigNode(ARM, cast(RigSession, session), link, report=lines.append)
        thread = Thread(target=node.run, args=(over.is_set,))
        thread.start()
        with Peer(first.address) as peer:
            peer.wait(lambda: ACTION in first.types)
            goal = peer.send_goal(ACTION, FAR)
            peer.wait(lambda: peer.feedback(goal))
    try:
        with ProtocolServer(port) as second, Peer(second.address) as peer:
            peer.wait(lambda: len(second.types) == 8)
            peer.wait(lambda: len(lines) == 3)
            assert lines == [
                f"link to {first.address} lost; the joints come to rest",
                "goal: the link to rosbridge was lost",
                f"link to {first.address} is back",
            ]
            assert peer.result(peer.send_goal(ACTION, goal_of([[0.1, 0.0]], [0.3])))["status"] == SUCCEEDED
    finally:
        over.set()
        thread.join()
        link.close()
        link.close()


def test_a_loop_that_ends_ends_the_node(bench: Bench) -> None:
    session = FakeSession()
    session.is_running = False
    with Rosbridge(bench.server.address) as link, pytest.raises(RigLoopError, match="the loop's process is gone"):
        RigNode(ARM, cast(RigSession, session), link, namespace="/other").run(lambda: False)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"namespace": "layflat"}, "namespace: 'layflat' is no namespace of ROS; give one such as /layflat"),
        ({"namespace": "/paper-arm"}, "namespace: '/paper-arm' is no namespace of ROS"),
        ({"namespace": "/1"}, "namespace: '/1' is no namespace of ROS"),
        ({"rate": 0.0}, "rate: 0 Hz; give 0.1 to 200"),
        ({"rate": float("nan")}, "rate: nan Hz; give 0.1 to 200"),
    ],
)
def test_wrong_options_are_one_line(options: dict[str, Any], text: str, bench: Bench) -> None:
    with Rosbridge(bench.server.address) as link, pytest.raises(InputError) as refusal:
        RigNode(ARM, cast(RigSession, bench.session), link, **options)
    assert str(refusal.value).startswith(text)


@pytest.mark.parametrize(
    ("address", "text"),
    [
        (
            "localhost:9090",
            "rosbridge: 'localhost:9090' is no address of a server; give one such as ws://localhost:9090",
        ),
        ("ws://127.0.0.1:9", "rosbridge: no rosbridge at ws://127.0.0.1:9 ("),
    ],
)
def test_a_server_that_is_not_there_is_named(address: str, text: str) -> None:
    with pytest.raises(InputError) as refusal:
        Rosbridge(address)
    assert str(refusal.value).startswith(text)
