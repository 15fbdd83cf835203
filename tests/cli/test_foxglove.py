"""The command `layflat foxglove`, and the option by which rigs are shown: what they read, serve and refuse."""

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from layflat.sim import rollout, save
from tests.cli.commands import LAYFLAT, layflat, refused
from tests.docs.setups import write_bench_log, write_rig_log
from tests.foxglove.messages import Viewer, positions, read_messages


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("foxglove")
    save(rollout("paper-arm", {"large": "5 deg"}, duration="0.5 s"), place / "arm.nc")
    write_bench_log(place)
    write_rig_log(place)
    assert layflat("log", "repair", "run.mcap.part", cwd=place).returncode == 0
    assert layflat("log", "map", "bench.csv", "--machine", "mine.toml", cwd=place).returncode == 0
    return place


@contextmanager
def started(*words: str, cwd: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A command that serves, and its address; Ctrl-C ends it."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen([*LAYFLAT, *words], stdout=subprocess.PIPE, text=True, env=environment, cwd=cwd) as command:
        assert command.stdout is not None
        try:
            line = command.stdout.readline()
            while "ws://" not in line:
                line = command.stdout.readline()
                assert line
            assert command.stdout.readline().startswith("https://app.foxglove.dev")
            yield command, line.partition(" at ")[2].split()[0]
            command.send_signal(signal.SIGINT)
            command.wait(60)
        finally:
            command.kill()


@pytest.mark.parametrize(
    ("words", "joints"),
    [
        (["arm.nc"], ["large", "small"]),
        (["run.mcap"], ["small"]),
        (["bench.csv", "--mapping", "bench-mapping.toml", "--machine", "mine.toml"], ["small"]),
        (["run.nc"], ["small"]),
    ],
)
def test_runs_and_logs_of_all_kinds_become_files(words: list[str], joints: list[str], folder: Path) -> None:
    out = folder / "out" / f"{words[0]}.mcap"
    assert layflat("foxglove", *words, "--out", str(out), cwd=folder).stdout == f"wrote {out}\n"
    topics = read_messages(out)
    assert {f"/joint/{name}" for name in joints} == {name for name in topics if name.startswith("/joint/")}
    assert {"/joint_states", "/tf", "/scene"} <= set(topics)


def test_a_bench_log_without_a_machine_has_no_arm(folder: Path) -> None:
    out = folder / "bare.mcap"
    done = layflat("foxglove", "bench.csv", "--mapping", "bench-mapping.toml", "--out", str(out), cwd=folder)
    assert done.returncode == 0, done
    assert "/tf" not in read_messages(out)


def test_a_log_is_played_until_it_is_stopped(folder: Path) -> None:
    words = ("foxglove", "arm.nc", "--port", "0", "--speed", "4")
    with started(*words, cwd=folder) as (command, address), Viewer(address) as viewer:
        viewer.receive(
            lambda: viewer.topics["/joint_states"][-1:] and viewer.topics["/joint_states"][-1][0] == 5 * 10**8
        )
    assert command.returncode == 0
    from layflat.sim import open_run

    assert positions(viewer.topics["/joint_states"]) == open_run(folder / "arm.nc")["angle"].values.tolist()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["none.nc"], "none.nc: can't be read as a run"),
        (["none.mcap"], "none.mcap: "),
        (
            ["bench.csv"],
            "bench.csv: its columns (t [ms], theta [deg], valve [V]) are not layflat's own signals; give a mapping",
        ),
        (["arm.nc", "--speed", "0"], "--speed: 0 is not a speed; give a number above 0"),
        (["arm.nc", "--speed", "nan"], "--speed: nan is not a speed; give a number above 0"),
        (["arm.nc", "--speed", "fast"], "Invalid value for '--speed'"),
        (["arm.nc", "--speed", "2", "--out", "new.mcap"], "--speed: is for playing, and --out writes a file"),
        (["arm.nc", "--machine", "picking-arm", "--out", "new.mcap"], "paper-arm: has the joints large, small; give"),
        (["arm.nc", "--out", "new.bag"], "--out: 'new.bag' has an unknown format; give a name such as run.mcap"),
        (["arm.nc", "--out", "run.mcap"], "run.mcap: is there already, and not from this command"),
        (["arm.nc", "--host", "192.0.2.1"], "--host: '192.0.2.1' can't be had"),
    ],
)
def test_mistakes_are_one_line(words: list[str], expected: str, folder: Path) -> None:
    before = sorted(folder.iterdir()), (folder / "run.mcap").read_bytes()
    assert refused("foxglove", *words, cwd=folder).startswith(f"layflat: {expected}")
    assert before == (sorted(folder.iterdir()), (folder / "run.mcap").read_bytes())


@pytest.mark.parametrize(
    "words",
    [
        "foxglove arm.nc --port",
        "rig run paper-arm --driver simulated --foxglove",
        "panel paper-arm --no-browser --foxglove",
    ],
)
def test_a_port_in_use_is_named_before_anything_moves(words: str, folder: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        line = refused(*words.split(), str(port), cwd=folder)
    option = words.rpartition(" ")[2]
    assert line.startswith(f"layflat: {option}: port {port} can't be had (Address already in use)")
    assert not (folder / "build/rig").exists()


def test_a_rig_that_runs_is_shown(folder: Path) -> None:
    """Without demands; the viewer gets rows with the log's numbers, whichever reach it."""
    from layflat.rig.recorder.run import read_run

    (folder / "patient.toml").write_text(
        'extends = "paper-small-joint"\nname = "arm"\n[safety]\nsetpoint_age = "0.3 s"\n', encoding="utf-8"
    )
    words = (
        "rig",
        "run",
        "patient.toml",
        "--driver",
        "simulated",
        "--duration",
        "1 s",
        "--foxglove",
        "0",
        "--out",
        "rig",
    )
    with started(*words, cwd=folder) as (_, address), Viewer(address) as viewer:
        viewer.receive(lambda: len(viewer.topics["/joint_states"]) > 40, seconds=120.0)
    (log,) = [path for path in (folder / "rig").glob("*.mcap") if "fault" not in path.name]
    measured = read_run(log)["measured_angle"].to_numpy()
    shown = np.array(positions(viewer.topics["/joint_states"]))
    assert np.isin(shown, measured).all()
    assert any("starting" in one.message for _, one in viewer.topics["/events"])


def test_the_rig_of_a_panel_is_shown(folder: Path) -> None:
    pytest.importorskip("nicegui")
    words = ("panel", "paper-small-joint", "--no-browser", "--port", "0", "--foxglove", "0", "--out", "panel")
    with started(*words, cwd=folder) as (_, address), Viewer(address) as viewer:
        viewer.receive(lambda: len(viewer.topics["/joint/small"]) > 5 and viewer.topics["/tf"], seconds=120.0)
    assert viewer.info["name"] == "paper-small-joint"
    assert viewer.topics["/events"][0][1].message == "off"
