"""The command that learns a repeated motion."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.machine import load
from layflat.motion.demand_file import read_demand, write_demand
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointLine
from tests.cli.commands import layflat, refused

ARM = load("paper-arm-tracking")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("learn")
    for name, end in (("move", 20.0), ("other", 25.0)):
        motion = plan_time_optimal(ARM, JointLine(np.radians([-20.0, -20.0]), np.radians([end, 20.0])))
        q, v, a = motion.rows(ARM.cycle)
        path = folder / f"{name}-demand.csv"
        write_demand(ARM, motion.times(ARM.cycle), q, path, velocity=v, acceleration=a)
    plant = 'extends = "paper-arm-tracking"\nname = "plant"\n\n[supply]\npressure_gauge = "4.5 bar"\n'
    (folder / "plant.toml").write_text(plant, encoding="utf-8")
    return folder


def test_repeats_are_simulated_on_another_plant(folder: Path) -> None:
    words = (
        "motion",
        "learn",
        "move-demand.csv",
        "paper-arm-tracking",
        "--plant",
        "plant.toml",
        "--repeats",
        "3",
        "--out",
        "sim",
    )
    done = layflat(*words, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert max(map(len, done.stdout.splitlines())) <= 100
    written = sorted(path.name for path in (folder / "sim").iterdir())
    assert written == ["move-learnt-demand.csv", "move-learnt.png", "move.learnt"]
    demand = read_demand(ARM, folder / "sim/move-learnt-demand.csv", ARM.cycle)
    assert demand.accelerations is not None
    said = (folder / "sim/move.learnt").read_text()
    assert layflat(*words, cwd=folder).returncode == 0
    assert (folder / "sim/move.learnt").read_text() == said


def test_it_learns_from_runs_of_its_own_demands(folder: Path) -> None:
    words = ("motion", "learn", "move-demand.csv", "paper-arm-tracking", "--out", "host")
    assert layflat(*words, "--begin", cwd=folder).returncode == 0
    errors = []
    for seed in (1, 2, 3):
        sent = ("--demand", "host/move-learnt-demand.csv", "--out", "runs", "--seed", str(seed))
        assert layflat("simulate", "paper-arm-tracking", *sent, cwd=folder).returncode == 0
        done = layflat(*words, "--from", "runs/paper-arm-tracking.nc", cwd=folder)
        assert done.returncode == 0, done.stderr
        rows = [line.split("│") for line in done.stdout.splitlines() if "│" in line]
        errors.append(float(rows[-1][1]))
    assert errors[-1] < 0.7 * errors[0]
    words = (*words[:4], "--out", "elsewhere")
    line = refused(*words, "--from", "runs/paper-arm-tracking.nc", "--learnt", "sim/move.learnt", cwd=folder)
    assert (
        "is not of a run of the demand to send next; give a run of the demand that `layflat motion learn` wrote" in line
    )


def test_mistakes_give_one_line(folder: Path) -> None:
    assert (
        layflat(
            "motion", "learn", "move-demand.csv", "paper-arm-tracking", "--begin", "--out", "of", cwd=folder
        ).returncode
        == 0
    )
    learnt = ("--learnt", "of/move.learnt", "--out", "no")
    line = refused("motion", "learn", "other-demand.csv", "paper-arm-tracking", *learnt, cwd=folder)
    assert line == "layflat: of/move.learnt: was learnt for another motion; give that motion, or learn anew"
    line = refused("motion", "learn", "move-demand.csv", "plant.toml", *learnt, cwd=folder)
    assert "was learnt with another machine, 'paper-arm-tracking'" in line
    line = refused(
        "motion", "learn", "move-demand.csv", "paper-arm-tracking", "--plant", "paper-small-joint", cwd=folder
    )
    assert "give a machine with joints" in line
    line = refused(
        "motion", "learn", "move-demand.csv", "paper-arm-tracking", "--from", "a.nc", "--plant", "b", cwd=folder
    )
    assert line == "layflat: --plant: cannot be combined with --from; give one or the other"
    for option in (["--begin"], ["--from", "a.nc"]):
        line = refused(
            "motion", "learn", "move-demand.csv", "paper-arm-tracking", "--repeats", "3", *option, cwd=folder
        )
        assert line.startswith(f"layflat: --repeats: has no effect beside {option[0]}")
    assert "--begin" in refused(
        "motion", "learn", "move-demand.csv", "paper-arm-tracking", "--begin", "--from", "a", cwd=folder
    )
    assert not (folder / "no").exists()


def test_ctrl_c_keeps_the_repeats_that_are_done(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from layflat.sim import repeats

    simulated = repeats.simulated_repeats

    def stopped(*args: Any, **options: Any) -> Iterator[repeats.SimulatedRepeat]:
        runs = simulated(*args, **options)
        yield next(runs)
        yield next(runs)
        raise KeyboardInterrupt

    monkeypatch.setattr(repeats, "simulated_repeats", stopped)
    done = layflat("motion", "learn", "move-demand.csv", "paper-arm-tracking", "--out", "stopped", cwd=folder)
    assert done.returncode == 130
    assert "stopped after 2 of 6 repeats; partial results are in stopped/move.learnt" in done.stderr
    assert json.loads((folder / "stopped/move.learnt").read_text())["repeats"] == 2
    assert (folder / "stopped/move-learnt-demand.csv").exists()


def test_what_was_learnt_is_not_replaced(folder: Path) -> None:
    words = ("motion", "learn", "move-demand.csv", "paper-arm-tracking", "--out", "kept")
    assert layflat(*words, "--repeats", "1", cwd=folder).returncode == 0
    said = (folder / "kept/move.learnt").read_text()
    for other in (["--begin"], ["--repeats", "2"]):
        assert "--repeats 1` wrote; give another place, or --force" in refused(*words, *other, cwd=folder)
        assert (folder / "kept/move.learnt").read_text() == said
    assert layflat(*words, "--begin", "--force", cwd=folder).returncode == 0
    assert (folder / "kept/move.learnt").read_text() != said
