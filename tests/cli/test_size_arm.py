"""Sizing of arms and their tasks from the command line: what is written, and what is refused in one line."""

import csv
from pathlib import Path

import pytest

from layflat import extras
from layflat.design.arm import TASK_LIBRARY, read_task
from layflat.machine import load
from layflat.solids.totals import list_built_parts
from tests.cli.commands import layflat, refused

ASKED = ("--reach", "0.5 m", "--payload", "0.5 kg", "--supply", "5 bar", "--time", "0.8 s")


def test_an_arm_is_sized_and_checked(tmp_path: Path) -> None:
    done = layflat("arm", "size", *ASKED, "--joints", "2", "--name", "small-arm", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    for told in ("shoulder", "elbow", "small-arm: 0.5 kg, moves of 0.80 s, 5 bar", "mass: "):
        assert told in done.stdout
    path = tmp_path / "small-arm.toml"
    assert list(load(path).joints) == ["shoulder", "elbow"]
    drawn = {f"small-arm-{joint}-{what}" for joint in ("shoulder", "elbow") for what in ("cam.svg", "layout.svg")}
    assert drawn | {"small-arm.toml", "small-arm-arm.png"} <= {file.name for file in tmp_path.iterdir()}
    checked = layflat("machine", "check", str(path))
    assert checked.stdout.strip() == f"{path}: a valid description of 2 joints"


def test_masses_are_compared(tmp_path: Path) -> None:
    grid = ("--pressures", "3 bar, 6 bar", "--times", "0.3 s, 0.8 s, 1.6 s")
    done = layflat("arm", "size", *ASKED, "--joints", "1", "--pareto", *grid, "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "sized-arm-pareto.png").exists()
    with (tmp_path / "sized-arm-pareto.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["supply_bar_gauge"] for row in rows] == ["3"] * 3 + ["6"] * 3
    assert [row["time_s"] for row in rows] == ["0.3", "0.8", "1.6"] * 2
    masses = [float(row["mass_kg"]) for row in rows]
    assert masses[:3] == sorted(masses[:3], reverse=True)
    assert all(high < low for low, high in zip(masses[:3], masses[3:], strict=True))
    assert [row["undominated"] for row in rows] == ["0"] * 3 + ["1"] * 3


@pytest.mark.skipif(not extras.available("cad"), reason="no extra cad; pip install layflat[cad]")
def test_costs_are_compared(tmp_path: Path) -> None:
    prices = tmp_path / "prices.toml"
    prices.write_text('[bought]\n"*" = "2"\n', encoding="utf-8")
    grid = ("--pressures", "3 bar, 5 bar", "--times", "0.8 s", "--prices", str(prices))
    done = layflat("arm", "size", *ASKED, "--joints", "1", "--pareto", *grid, "--out", str(tmp_path / "out"))
    assert done.returncode == 0, done.stderr
    assert "as built: " in done.stdout
    assert "no price, counted as nothing: 1 cylinder" in done.stderr
    with (tmp_path / "out/sized-arm-pareto.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    parts = list_built_parts(load(tmp_path / "out/sized-arm.toml"))
    assert float(rows[1]["built_mass_kg"]) == pytest.approx(parts.mass, rel=1e-5)
    assert float(rows[1]["cost"]) == 2 * sum(part.quantity for part in parts.parts if part.bought)


def test_tasks_are_listed_and_printed(tmp_path: Path) -> None:
    listed = layflat("task", "list").stdout
    assert all(name in listed for name in TASK_LIBRARY.names)
    copy = tmp_path / "copy.toml"
    copy.write_text(layflat("task", "show", "picking-arm").stdout, encoding="utf-8")
    assert read_task(copy).model_dump() == read_task("picking-arm").model_dump()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "arm size: TASK: is missing; see `layflat task list`, or give --reach, --payload, --supply and --time"),
        (("--reach", "1 m"), "task: payload: is missing; docs/sizing-arms.md shows a complete task"),
        (("nothing.toml",), "nothing.toml: "),
        (("picking-arm", "--volume", "1 m"), "--volume: '1 m' is no box; give two corners, such as"),
        (("picking-arm", "--volume", "0 m, 0 m to 1 m, 1 m, 1 m"), "--volume.low: has too few values"),
        (("picking-arm", "--point", "1 m"), "--point.0: has too few values; give 3"),
        (("picking-arm", "--configuration", "1"), "--configuration.0.0: '1' is a bare number"),
        (("picking-arm", "--pose", "1 deg"), "layflat: --pose is --configuration now"),
        (("picking-arm", "--times", "1 s"), "--times: needs --pareto"),
        (("picking-arm", "--built"), "--built: needs --pareto"),
        (("picking-arm", "--pareto", "--prices", "none.toml"), "none.toml: can't be read"),
        (("picking-arm", "--pareto", "--pressures", "4"), "--pressures: '4' is a bare number"),
        (("picking-arm", "--time", "1 s", "--acceleration", "1 m/s^2"), "give one of them"),
        (("picking-arm", "--payload", "80 kg"), "picking-arm: joint 'base': would have to give at least"),
    ],
)
def test_one_line_says_what_is_wrong(words: tuple[str, ...], told: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert told in refused("arm", "size", *words, "--out", str(out))
    assert not list(out.glob("*"))
