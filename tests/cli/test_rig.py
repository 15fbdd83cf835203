"""Commands of a rig as a person uses them: a virtual rig in one process, the rig's own in others, in real time."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from layflat import cli
from layflat.errors import LayflatError
from layflat.rig.device.failures import FAILURES_BY_NAME
from layflat.rig.recorder.run import read_run
from layflat.rig.safety.faults import RigState
from tests.cli.served_rig import LAYFLAT, ServedRig

PATIENT = """
extends = "paper-arm-fast"
name = "arm"
[interface]
watchdog_cycles = 40
dump_after = "0.4 s"
[interface.modbus]
timeout = "100 ms"
[interface.serial]
timeout = "100 ms"
[safety]
setpoint_age = "0.3 s"
"""
"""Replies may take long: a computer may have other work."""

pytestmark = pytest.mark.realtime


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rig")
    (folder / "arm.toml").write_text(PATIENT)
    return folder


@pytest.fixture(scope="module")
def modbus(place: Path) -> Iterator[ServedRig]:
    served = ServedRig("arm.toml", "--modbus", "0", cwd=place)
    yield served
    assert served.end() == 0


@pytest.fixture
def serial(place: Path) -> Iterator[ServedRig]:
    served = ServedRig("arm.toml", "--link", "tty", cwd=place)
    yield served
    if served.process.poll() is None:  # the test failed
        served.end(signal.SIGKILL)


def start(*words: str, cwd: Path) -> subprocess.Popen[str]:
    return subprocess.Popen([*LAYFLAT, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=cwd)


def refused(*words: str) -> str:
    with pytest.raises(LayflatError) as error:
        cli.app(list(words), standalone_mode=False)
    assert "\n" not in str(error.value)
    return str(error.value)


def complete(path: Path) -> None:
    """A log that begins without air and ends without, with no cycle missing."""
    log = read_run(path)
    assert log["mode"].values[0] == RigState.STARTING or log["mode"].values[0] == RigState.OFF
    assert log["mode"].values[-1] == RigState.STOPPED
    assert log["air"].values[-1] == 0.0
    time_, elapsed = log["time"].to_numpy(), log["elapsed"].to_numpy()
    assert np.all(np.diff(time_) <= elapsed[1:] + 0.002)


def test_a_move_through_modbus_settles_and_is_logged(modbus: ServedRig, place: Path) -> None:
    words = ("rig", "run", "arm.toml", "--driver", modbus.address, "--out", "out")
    done = subprocess.run(
        [*LAYFLAT, *words, "--demand", "15 deg, 10 deg", "--demand", "large=5 deg @ 1.7 s", "--duration", "3.3 s"],
        capture_output=True, text=True, cwd=place, check=False, timeout=100.0,
    )  # fmt: skip
    assert done.returncode == 0, done
    rows = [line.split("│") for line in done.stdout.splitlines() if "│ large" in line or "│ small" in line]
    assert len(rows) == 4
    assert all(float(row[2]) < 1.5 and abs(float(row[4])) < 0.3 for row in rows), done.stdout
    assert "cycles, late by" in done.stdout
    assert max(len(line) for line in done.stdout.splitlines() if "late by" not in line) <= 100
    log, figure = place / "out" / "arm-rig.mcap", place / "out" / "arm-rig.png"
    complete(log)
    assert modbus.vented()
    assert figure.stat().st_size > 10_000
    assert json.loads(read_run(log).attrs["notes"])["driver"] == modbus.address
    again = place / "again.png"
    cli.app(["log", "plot", str(log), "--out", str(again)], standalone_mode=False)
    assert again.read_bytes() == figure.read_bytes()


def test_ctrl_c_through_serial_is_a_controlled_stop(serial: ServedRig, place: Path) -> None:
    assert serial.address == "serial://tty"
    words = ("rig", "run", "arm.toml", "--driver", f"serial://{place / 'tty'}", "--out", "serial")
    running = start(*words, "--demand", "large=15 deg, small=10 deg", "--duration", "60 s", cwd=place)
    wait_until_moving(place / "serial" / "arm-rig.mcap.part")
    second = subprocess.run([*LAYFLAT, *words], capture_output=True, text=True, cwd=place, check=False, timeout=60.0)
    assert second.returncode == 2, second
    assert "is driven by process" in second.stderr
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=60.0)
    assert running.returncode == 130, (out, err)
    assert err.strip() == "layflat: the run ended early: stopped"
    rows = [line.split("│") for line in out.splitlines() if "│ large" in line or "│ small" in line]
    assert [float(row[2]) < 1.5 for row in rows] == [True, True], out
    complete(place / "serial" / "arm-rig.mcap")
    assert {path.suffix for path in (place / "serial").glob("arm-rig*")} == {".mcap", ".png"}
    assert serial.vented()
    assert serial.end(signal.SIGTERM) == 0
    assert not (place / "tty").is_symlink()


def wait_until_moving(part: Path) -> None:
    """Wait until a log holds the start and a whole move, about four seconds."""
    until = time.monotonic() + 60.0
    while not part.exists() or part.stat().st_size < 800_000:
        assert time.monotonic() < until
        time.sleep(0.05)


def test_a_demand_file_is_followed(modbus: ServedRig, place: Path) -> None:
    times = np.arange(0.0, 1.5, 0.05)
    rows = [f"{t:.2f},{10.0 * np.sin(3.0 * t):.3f},{-8.0 * np.sin(2.0 * t):.3f}" for t in times]
    (place / "sines.csv").write_text("\n".join(["time [s],demand.large [deg],demand.small [deg]", *rows]))
    words = ("rig", "run", "arm.toml", "--driver", modbus.address, "--out", "file", "--demand", "sines.csv")
    done = subprocess.run([*LAYFLAT, *words], capture_output=True, text=True, cwd=place, check=False, timeout=100.0)
    assert done.returncode == 0, done
    assert "sines.csv" in done.stdout
    log = read_run(place / "file" / "arm-rig.mcap")
    moving = log.sel(time=log["time"][log["mode"].values == RigState.MOVING])
    asked = np.degrees(np.ptp(moving["demand"].to_numpy(), axis=0))
    assert asked == pytest.approx([10.0 + 10.0 * 0.93, 8.0], abs=3.0)
    error = np.degrees(moving["angle"].to_numpy() - moving["demand"].to_numpy())
    assert np.sqrt(np.mean(error**2)) < 6.0


def test_a_run_ends_when_its_recorder_dies_and_the_log_can_be_repaired(modbus: ServedRig, place: Path) -> None:
    words = ("rig", "run", "arm.toml", "--driver", modbus.address, "--out", "dies", "--demand", "10 deg")
    part = place / "dies" / "arm-rig.mcap.part"
    running = start(*words, "--duration", "60 s", cwd=place)
    wait_until_moving(part)
    os.kill(who_writes(part, running.pid), signal.SIGKILL)
    _, err = running.communicate(timeout=60.0)
    assert running.returncode == 3, err
    assert "the run ended early: the recorder is gone" in err
    assert "`layflat log repair" in err
    assert modbus.vented()
    cli.app(["log", "repair", str(part)], standalone_mode=False)
    assert len(read_run(place / "dies" / "arm-rig.mcap")["time"]) > 100


def who_writes(path: Path, parent: int) -> int:
    """The child process that has a file open."""
    for child in Path(f"/proc/{parent}/task/{parent}/children").read_text().split():
        for handle in Path(f"/proc/{child}/fd").iterdir():
            if handle.resolve() == path.resolve():
                return int(child)
    raise AssertionError(f"nobody writes {path}")


def test_an_e_stop_ends_a_run_with_status_3(modbus: ServedRig, place: Path) -> None:
    assert modbus.ask("fail e-stop").startswith("e-stop: ")
    assert "e-stop pressed" in modbus.ask("state")
    words = ("rig", "run", "arm.toml", "--driver", modbus.address, "--out", "stopped", "--demand", "10 deg")
    done = subprocess.run([*LAYFLAT, *words], capture_output=True, text=True, cwd=place, check=False, timeout=100.0)
    assert modbus.ask("heal e-stop") == "e-stop: healed"
    assert done.returncode == 3, done
    assert "the run ended early: e-stop" in done.stderr
    assert "error" in done.stdout
    assert np.all(read_run(place / "stopped" / "arm-rig.mcap")["supply"].to_numpy() < 1.1e5)


def test_a_served_rig_says_what_it_is_told(modbus: ServedRig) -> None:
    assert modbus.ask("fail stuck-spool small 0.2") == "stuck-spool: the joint's valve stays at an opening"
    assert modbus.ask("heal stuck-spool small") == "stuck-spool: healed"
    modbus.send("failures")
    lines = [modbus.line() for _ in FAILURES_BY_NAME]
    assert any(line.startswith("burst-hose: ") for line in lines)
    for text, what in (
        ("fail moonquake", "'moonquake' is not a failure"),
        ("fail push elbow 1", "unknown joint 'elbow'; give large or small"),
        ("fail push large much", "neither joint nor number"),
        ("dance", "'dance' is not understood"),
    ):
        modbus.send(text)
        assert modbus.process.stderr is not None
        assert what in modbus.process.stderr.readline()
    port = modbus.address.rsplit(":", 1)[1]
    assert "address already in use" in refused("rig", "serve", "paper-arm", "--modbus", port)


def test_a_rig_is_checked(modbus: ServedRig, place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arm = str(place / "arm.toml")
    status = cli.app(["rig", "check", arm, "--driver", modbus.address], standalone_mode=False)
    out = capsys.readouterr().out
    assert "pressure of small" in out
    assert status in (None, 0, 3)  # 3 where this computer was too busy
    modbus.ask("fail angle-open large")
    assert cli.app(["rig", "check", arm, "--driver", modbus.address, "--air"], standalone_mode=False) == 3
    modbus.ask("heal angle-open large")
    out = " ".join(capsys.readouterr().out.split())
    assert "open or shorted" in out
    assert "not tried" in out
