"""Mistakes in commands of a rig, and what is told while one runs: nothing moves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from layflat import cli
from layflat.cli.rig_run import status_line
from layflat.errors import LayflatError
from layflat.machine import load
from layflat.rig.record import RowLayout
from layflat.rig.safety.faults import Fault, RigState
from layflat.rig.session import RigSnapshot


def refused(*words: str) -> str:
    with pytest.raises(LayflatError) as error:
        cli.app(list(words), standalone_mode=False)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["--driver", "modbus://127.0.0.1:1"], "can't be reached (Connection refused)"),
        (["--driver", "serial:///dev/nothing"], "is not there"),
        (["--driver", "telepathy"], "is not a driver's address"),
        (["--driver", "simulated", "--demand", "61 deg"], "stroke of joint 'large'; stay within +-60 deg"),
        (["--driver", "simulated", "--demand", "1 deg, 2 deg, 3 deg"], "has 3 values"),
        (["--driver", "simulated", "--demand", "absent.csv"], "can't be read"),
        (["--driver", "simulated", "--demand", "5 deg @ 4 s", "--duration", "2 s"], "ends before the last move"),
        (["--driver", "simulated", "--duration", "-1 s"], "is not a time to run"),
        (["--driver", "simulated", "--out", "/proc/rig"], "can't write here"),
    ],
)
def test_mistakes_are_told_before_anything_moves(
    words: list[str], line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert line in refused("rig", "run", "paper-arm", *words)
    assert not list(tmp_path.rglob("*.mcap*"))


def test_other_mistakes_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "has no valve or sensors" in refused("rig", "run", "rig-kevlar", "--driver", "simulated")
    assert "give one of both" in refused("rig", "serve", "paper-arm")
    assert "give one of both" in refused("rig", "serve", "paper-arm", "--modbus", "0", "--serial")
    assert "nobody" in refused("rig", "serve", "nobody", "--modbus", "0")
    (tmp_path / "taken").write_text("")
    assert "can't be made" in refused("rig", "serve", "paper-arm", "--link", "taken")
    (tmp_path / "far.csv").write_text("time [s],demand.large [deg],demand.small [deg]\n0,0,0\n1,0,70\n")
    assert "line 3: asks joint 'small' for 70 deg at 1 s; stay within +-60 deg" in refused(
        "rig", "run", "paper-arm", "--driver", "simulated", "--demand", "far.csv"
    )


def test_the_status_is_a_line() -> None:
    layout = RowLayout.for_machine(load("paper-arm"))
    row = np.zeros(layout.width)
    row[layout.shared["mode"]], row[layout.shared["fault"]] = RigState.FAULT, Fault.VALVE_UNRESPONSIVE
    layout.named(row, "joint_fault")[1] = Fault.VALVE_UNRESPONSIVE
    line = status_line(RigSnapshot(layout, row), ["large", "small"])
    assert "FAULT joint 'small': air does not answer" in line
    assert "\n" not in line
    row[layout.shared["fault"]] = Fault.NONE
    assert "FAULT" not in status_line(RigSnapshot(layout, row), ["large", "small"])
