"""The loop in its own process, with a simulated driver, in real time."""

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from layflat.errors import InputError
from layflat.machine import load
from layflat.rig.safety.faults import RigState
from layflat.rig.session import STARTS_WITHIN, RigLoopError, RigSession
from tests.rig import fake_drivers as drivers

pytestmark = pytest.mark.realtime
ARM = load("paper-arm")


def wait(condition: Callable[[], bool], seconds: float = STARTS_WITHIN) -> None:
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.01)


def state(rig: RigSession) -> RigState | None:
    shot = rig.snapshot()
    return shot.state if shot is not None else None


def test_a_rig_starts_moves_and_stops(tmp_path: Path) -> None:
    recorder = partial(drivers.LineRecorder, tmp_path / "lines")
    with RigSession(ARM, drivers.simulated, recorder) as rig:
        assert rig.process.pid is not None
        os.kill(rig.process.pid, signal.SIGINT)  # as Ctrl-C would: the host decides
        with pytest.raises(InputError, match="one a joint"):
            rig.ask([0.1])
        with pytest.raises(InputError, match=r"unknown output 'gripper'; name it in interface\.outputs"):
            rig.switch("gripper", True)
        rig.start()
        wait(lambda: state(rig) is RigState.READY)
        rig.ask([0.2, 0.1])
        wait(lambda: state(rig) is RigState.MOVING)
        time.sleep(1.5)
        shot = rig.snapshot()
        assert shot is not None
        assert list(shot["averaged_angle"]) == pytest.approx([0.2, 0.1], abs=0.05)
    assert rig.process.exitcode == 0
    rig.close()  # once more
    assert any("cycles, late by" in line for line in rig.messages)
    assert "moving -> stopped" in (tmp_path / "lines").read_text()


@pytest.mark.parametrize(
    ("driver", "line"),
    [
        (drivers.absent, "modbus://127.0.0.1:5020: nobody answers; start the device"),
        (drivers.of_one_joint, "does not fit 'paper-arm': it has 1 joints, the machine 2"),
    ],
)
def test_what_is_wrong_is_one_line(driver: Callable[[], object], line: str) -> None:
    with pytest.raises(RigLoopError, match=line):
        RigSession(ARM, driver)  # type: ignore[arg-type]


def test_a_loop_that_breaks_is_told() -> None:
    with RigSession(ARM, drivers.breaking) as rig:
        rig.process.join(10.0)
        with pytest.raises(RigLoopError, match="out of order"):
            rig.check()


def host(pipe: object) -> None:
    rig = RigSession(ARM, drivers.simulated, partial(drivers.LineRecorder, Path(os.environ["LINES"])))
    rig.start()
    wait(lambda: state(rig) is RigState.READY)
    rig.ask([0.1, 0.1])
    pipe.send(rig.process.pid)  # type: ignore[attr-defined]
    time.sleep(60.0)


def test_a_host_that_is_killed_leaves_a_loop_that_vents_and_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LINES", str(tmp_path / "lines"))
    context = multiprocessing.get_context("spawn")
    mine, its = context.Pipe()
    process = context.Process(target=host, args=(its,))
    process.start()
    assert mine.poll(60.0)
    loop = mine.recv()
    time.sleep(0.3)
    assert process.pid is not None
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    wait(lambda: not Path(f"/proc/{loop}").exists() or "Z" in Path(f"/proc/{loop}/stat").read_text().split()[2])
    lines = (tmp_path / "lines").read_text()
    assert "setpoint stale" in lines
    assert "moving -> stopped" in lines


def broken_host(lines: Path) -> None:
    rig = RigSession(ARM, drivers.simulated, partial(drivers.LineRecorder, lines))
    rig.start()
    wait(lambda: state(rig) is RigState.READY)
    raise SystemExit(3)


def test_a_host_that_ends_without_closing_lets_the_loop_vent_and_ends_itself(tmp_path: Path) -> None:
    process = multiprocessing.get_context("spawn").Process(target=broken_host, args=(tmp_path / "lines",))
    process.start()
    process.join(60.0)
    ended = process.exitcode
    process.kill()
    assert ended == 3
    assert "setpoint stale" in (tmp_path / "lines").read_text()
