"""The commands about motions."""

from __future__ import annotations

from pathlib import Path

import pytest

from layflat.machine import load
from layflat.motion.demand_file import read_demand
from tests.cli.commands import layflat

AWAY = """
name = "away"
title = "a belt that leaves"
start = ["0 deg", "0 deg"]

[[segment]]
kind = "belt"
direction = "0 deg"
speeds = [["0 s", "0.4 m/s"], ["1.5 s", "0 m/s"]]
acceleration = "4 m/s^2"
"""


def test_motions_are_listed_and_printed() -> None:
    assert "tour" in layflat("motion", "list").stdout
    assert 'kind = "belt"' in layflat("motion", "show", "tour").stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("motion")
    (folder / "mine.toml").write_text(AWAY, encoding="utf-8")
    return folder


def test_a_motion_is_planned_and_simulated(folder: Path) -> None:
    done = layflat("motion", "plan", "mine.toml", "paper-arm-fast", "--out", "out", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert max(map(len, done.stdout.splitlines()[:3])) <= 100
    assert "1 belt" in done.stdout
    left = "segment 1: its target leaves the arm's reach at x = 661 mm, y = 400 mm, 0.728 s after it began; the arm"
    assert left in done.stdout
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["away-demand.csv", "away-motion.png"]
    rows = read_demand(load("paper-arm-fast"), folder / "out/away-demand.csv", 0.005)
    assert rows.velocities is not None
    assert rows.accelerations is not None
    run = layflat("simulate", "paper-arm-tracking", "--demand", "out/away-demand.csv", cwd=folder)
    assert run.returncode == 0, run.stderr
    missed = run.stdout.partition("away-demand.csv: large ")[2].split()
    assert float(missed[0]) < 0.5


def test_a_mistake_gives_one_line(folder: Path) -> None:
    done = layflat("motion", "plan", "mine.toml", "paper-small-joint", cwd=folder)
    assert done.returncode == 2
    assert done.stderr.strip() == "layflat: mine.toml: start: has 2 angles; give 1: small"
    assert not (folder / "build/motion").exists()


def test_a_motion_that_goes_nowhere_has_a_demand_that_can_be_followed(folder: Path) -> None:
    start = '["10 deg", "10 deg"]'
    text = f'name = "still"\ntitle = "x"\nstart = {start}\n[[segment]]\nkind = "joint"\nto = {start}\n'
    (folder / "still.toml").write_text(text, encoding="utf-8")
    done = layflat("motion", "plan", "still.toml", "paper-arm-fast", "--out", "out", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    angles = read_demand(load("paper-arm-fast"), folder / "out" / "still-demand.csv", 0.005).angles
    assert angles.shape == (2, 2)


def test_a_motion_of_weeks_is_refused_before_it_is_written(folder: Path) -> None:
    text = 'name = "long"\ntitle = "x"\nstart = ["0 deg", "0 deg"]\n[[segment]]\nkind = "wait"\nduration = "1000 h"\n'
    (folder / "long.toml").write_text(text, encoding="utf-8")
    done = layflat("motion", "plan", "long.toml", "paper-arm-fast", "--out", "out", cwd=folder)
    assert done.returncode == 2
    assert done.stderr.strip().endswith("3.6e+06 s are 7.2e+08 control cycles of 5 ms; give 10000 s or less")
