"""The command with a virtual rig in real time: air, a trajectory, the end."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from layflat.rig.recorder.run import read_run
from layflat_ros2.command import app
from layflat_ros2.messages import DIAGNOSTICS_TYPE, JOINT_STATE_TYPE
from protocol_server import Peer, ProtocolServer
from test_trajectory import goal_of

COMMAND = [sys.executable, "-c", "from layflat_ros2.command import main; main()"]
ENVIRONMENT = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
# A loop that waits for a busy processor is no failure here.
PATIENT = """extends = "paper-arm-tracking"
name = "patient"

[safety]
setpoint_age = "0.9 s"

[interface]
watchdog_cycles = 100
dump_after = "0.9 s"
"""


@contextmanager
def started(*words: str, cwd: Path) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [*COMMAND, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, cwd=cwd
    ) as command:
        try:
            yield command
        finally:
            command.kill()


def follow_a_trajectory(address: str, namespace: str, folder: Path) -> None:
    """Have the command serve a virtual rig at a server; a peer moves it, and compares its states with the log."""
    (folder / "patient.toml").write_text(PATIENT, encoding="utf-8")
    words = ("patient.toml", "--driver", "simulated", "--rosbridge", address, "--namespace", namespace, "--out", "logs")
    states = f"{namespace}/joint_states"
    with Peer(address) as peer, started(*words, cwd=folder) as command:
        for topic, kind in {states: JOINT_STATE_TYPE, "/diagnostics": DIAGNOSTICS_TYPE}.items():
            peer.send("subscribe", topic=topic, type=kind)

        def is_ready() -> bool:
            shown = [status for one in peer.messages("/diagnostics") for status in one["status"]]
            return any(one["name"] == "layflat: patient" and one["message"].startswith("ready") for one in shown)

        peer.wait(lambda: peer.messages(states), 180.0)
        assert peer.call(f"{namespace}/start")["success"]
        peer.wait(is_ready, 240.0)
        target = (np.array(peer.messages(states)[-1]["position"]) + 0.15).tolist()
        goal = peer.send_goal(f"{namespace}/follow_joint_trajectory", goal_of([target], [1.5]))
        assert peer.result(goal, 60.0) == {"error_code": 0, "error_string": "", "status": 4}
        assert peer.messages(states)[-1]["position"] == pytest.approx(target, abs=0.03)
        command.send_signal(signal.SIGINT)
        output, errors = command.communicate(timeout=60)
    assert command.returncode == 0, errors
    assert output.splitlines()[-1] == "wrote logs/patient-rig.mcap"
    measured = read_run(folder / "logs/patient-rig.mcap")["measured_angle"].to_numpy()
    shown = np.array([one["position"] for one in peer.messages(states)])
    assert np.isin(shown.round(12), measured.round(12)).all()  # a server in Rust reads numbers up to a last bit off


@pytest.mark.realtime
def test_a_virtual_rig_follows_a_trajectory(tmp_path: Path) -> None:
    with ProtocolServer() as server:
        follow_a_trajectory(server.address, "/layflat", tmp_path)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            ["paper-arm", "--driver", "simulated", "--rosbridge", "ws://127.0.0.1:9"],
            "--rosbridge: no rosbridge at ws://",
        ),
        (["paper-arm", "--driver", "simulated", "--namespace", "arm"], "--namespace: 'arm' is no namespace of ROS"),
        (["paper-arm", "--driver", "simulated", "--rate", "1000"], "--rate: 1000 Hz; give 0.1 to 200"),
        (["paper-arms", "--driver", "simulated"], "paper-arms"),
        (["paper-arm", "--driver", "usb"], ""),
    ],
)
def test_mistakes_are_one_line(words: list[str], text: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [*COMMAND, *words], capture_output=True, text=True, env=ENVIRONMENT, cwd=tmp_path, check=False
    )
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"layflat-ros2: {text}")
    assert list(tmp_path.iterdir()) == []


def test_commands_of_the_page_can_be_typed() -> None:
    from typer.main import get_command

    page = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    lines = [line.split()[1:] for line in page.splitlines() if line.startswith("layflat-ros2 ")]
    assert len(lines) == 2
    for words in lines:
        get_command(app).make_context("layflat-ros2", words)
