"""The commands about motions."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import layflat

from layflat.machine import load
from layflat.motion.demand_file import read_demand

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
    assert "tour" in layflat("motions").stdout
    assert 'kind = "belt"' in layflat("motions", "tour").stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("motion")
    (folder / "mine.toml").write_text(AWAY, encoding="utf-8")
    return folder


def test_a_motion_is_planned_and_simulated(folder: Path) -> None:
    done = layflat("motion", "mine.toml", "paper-arm-fast", "--out", "out", cwd=folder)
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
    done = layflat("motion", "mine.toml", "paper-small-joint", cwd=folder)
    assert done.returncode == 2
    assert done.stderr.strip() == "layflat: mine.toml: start: has 2 angles; give 1: small"
    assert not (folder / "build/motion").exists()
