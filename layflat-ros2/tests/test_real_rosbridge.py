"""The node with ROS 2: messages pass a real rosbridge server, its checks of types, and the middleware.

`make ros2-check` installs what it needs; without that these tests are left out.
"""

import json
import os
import random
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from threading import Event, Thread
from typing import cast

import numpy as np
import pytest

from fake_session import ARM, FakeSession
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import RigSession
from layflat_ros2 import RigNode, Rosbridge
from layflat_ros2.messages import DIAGNOSTICS_TYPE, JOINT_STATE_TYPE, PRESSURES_TYPE
from protocol_server import Peer
from ros2_prefix import environment, server_command
from test_command import follow_a_trajectory
from test_node import ACTION, COMMANDS, PRESSURES, STATES
from test_trajectory import goal_of
from tests.programs import skip_without

PREFIX = os.environ.get("LAYFLAT_ROS2_PREFIX")
LISTENER = """
import json
import rclpy
from sensor_msgs.msg import JointState

rclpy.init()
node = rclpy.create_node("listener")
received = []
node.create_subscription(JointState, "/layflat/joint_states", received.append, 10)
while len(received) < 3:
    rclpy.spin_once(node)
last = received[-1]
print(json.dumps([list(last.name), list(last.position), list(last.velocity), last.header.stamp.sec]))
"""  # a node of ROS's own library


class RealBench:
    """A node that runs, its session, a peer of the same server, and the domain of ROS that they are in."""

    def __init__(self, session: FakeSession, peer: Peer, lines: list[str], domain: int, address: str) -> None:
        self.session, self.peer, self.lines, self.domain, self.address = session, peer, lines, domain, address


@pytest.fixture(scope="module")
def bench() -> Iterator[RealBench]:
    if PREFIX is None:
        skip_without("ROS 2")
    domain = random.SystemRandom().randrange(1, 100)
    with socket.create_server(("127.0.0.1", 0)) as free:
        place = f"127.0.0.1:{free.getsockname()[1]}"
    with subprocess.Popen(
        [*server_command(Path(PREFIX)), "--bind", place],
        env=environment(Path(PREFIX), domain),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as server:
        session, lines, over = FakeSession(), list[str](), Event()
        try:
            wait_for(place)
            with Rosbridge(f"ws://{place}") as link, Peer(f"ws://{place}") as peer:
                node = RigNode(ARM, cast(RigSession, session), link, hardware="bench", report=lines.append)
                thread = Thread(target=node.run, args=(over.is_set,))
                thread.start()
                try:
                    yield RealBench(session, peer, lines, domain, link.address)
                finally:
                    over.set()
                    thread.join()
        finally:
            server.terminate()


def wait_for(place: str) -> None:
    host, _, port = place.partition(":")
    until = time.monotonic() + 20.0
    while True:
        with socket.socket() as attempt:
            if attempt.connect_ex((host, int(port))) == 0:
                return
        assert time.monotonic() < until
        time.sleep(0.05)


def test_messages_pass_its_types_with_the_same_numbers(bench: RealBench) -> None:
    bench.session.demand = np.array([0.1, -0.2])
    peer = bench.peer
    topics = {STATES: JOINT_STATE_TYPE, PRESSURES: PRESSURES_TYPE, "/diagnostics": DIAGNOSTICS_TYPE}
    for topic, kind in topics.items():
        peer.send("subscribe", topic=topic, type=kind)
    peer.wait(lambda: all(peer.messages(topic) for topic in topics) and peer.messages(STATES)[-1]["position"][0])
    shot = bench.session.snapshot()
    state = peer.messages(STATES)[-1]
    assert (state["name"], state["position"]) == (["large", "small"], [0.1, -0.2])
    assert state["velocity"] == shot["averaged_velocity"].tolist()
    assert [one["values"][0] for one in peer.messages(PRESSURES)[-1]["interface_values"]] == [0.25, 0.25]
    assert peer.messages("/diagnostics")[-1]["status"][0]["name"] == "layflat: paper-arm"
    bench.session.fault = Fault.DEMAND_LIMITED
    peer.wait(lambda: peer.messages("/diagnostics")[-1]["status"][0]["level"] == 1)
    bench.session.fault = Fault.NONE


def test_a_node_of_ros_reads_the_joint_states(bench: RealBench) -> None:
    bench.session.demand = np.array([0.3, -0.125])
    python = Path(str(PREFIX)) / "venv/bin/python"
    done = subprocess.run(
        [python, "-c", LISTENER],
        env=environment(Path(str(PREFIX)), bench.domain),
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert json.loads(done.stdout) == [["large", "small"], [0.3, -0.125], [0.25, 0.25], 1_780_000_000]


def test_a_goal_is_followed(bench: RealBench) -> None:
    bench.session.demand, bench.session.state = np.zeros(2), RigState.READY
    goal = bench.peer.send_goal(ACTION, goal_of([[0.2, -0.1], [0.3, 0.0]], [0.3, 0.6]))
    assert bench.peer.result(goal) == {"error_code": 0, "error_string": "", "status": 4}
    assert bench.session.asked[-1][0] == pytest.approx([0.3, 0.0])
    feedback = bench.peer.feedback(goal)
    assert len(feedback) > 3
    assert feedback[-1]["actual"]["positions"] == pytest.approx([0.3, 0.0], abs=0.1)


def test_the_reason_of_an_aborted_goal_arrives(bench: RealBench) -> None:
    result = bench.peer.result(bench.peer.send_goal(ACTION, goal_of([[9.0, 0.0]], [3.0])))
    assert (result["status"], result["error_code"]) == (6, -1)
    assert result["error_string"].startswith("joint 'large' goes to 515.7 deg; keep inside the working stroke of")


def test_a_goal_is_canceled(bench: RealBench) -> None:
    goal = bench.peer.send_goal(ACTION, goal_of([[0.5, -0.5]], [5.0]))
    bench.peer.wait(lambda: bench.peer.feedback(goal))
    bench.peer.send("cancel_action_goal", id=goal, action=ACTION)
    assert bench.peer.result(goal)["status"] == 5


def test_services_and_commands_arrive(bench: RealBench) -> None:
    assert bench.peer.call("/layflat/start")["success"] is True
    assert bench.session.requests == ["start"]
    command = {"name": ["small", "large"], "position": [0.2, 0.1], "velocity": [], "effort": []}
    bench.peer.send("advertise", topic=COMMANDS, type=JOINT_STATE_TYPE)
    count = len(bench.session.asked)
    bench.peer.wait(
        lambda: bench.peer.send("publish", topic=COMMANDS, msg=command) and len(bench.session.asked) > count
    )
    assert bench.session.asked[-1] == ([0.1, 0.2], None)


def test_a_virtual_rig_follows_a_trajectory(bench: RealBench, tmp_path: Path) -> None:
    follow_a_trajectory(bench.address, "/arm", tmp_path)


def test_the_server_had_nothing_to_complain_of(bench: RealBench) -> None:
    assert not [line for line in bench.lines if line.startswith("rosbridge")]
