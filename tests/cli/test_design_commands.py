"""The commands `design` and `size`: what they write with and without extras, and options that do not fit together."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from layflat.cli import app
from layflat.errors import InputError
from layflat.machine import load

SIZE = ("joint", "size", "--torque", "8 N m", "--stroke", "90 deg", "--supply", "2.5 bar")


def layflat(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words], standalone_mode=False)


def refused(*words: object) -> str:
    error = layflat(*words).exception
    assert isinstance(error, InputError)
    assert "\n" not in str(error)
    return str(error)


def written(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("command", [("joint", "design", "paper-arm"), SIZE], ids=["design", "size"])
def test_without_ezdxf_everything_else_is_written(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, rest = tmp_path / "whole", tmp_path / "rest"
    done = layflat(*command, "--out", whole)
    assert (done.exit_code, done.stderr) == (0, "")
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    done = layflat(*command, "--out", rest)
    assert done.exit_code == 0, done.exception
    (line,) = done.stderr.splitlines()
    assert line == "layflat: no DXF: needs ezdxf, not installed; install it: pip install 'layflat[drawing]'"
    left_out = {name for name in written(whole) if name.endswith(".dxf")}
    assert len(left_out) == (2 if command[1] == "design" else 1)
    assert written(rest) == written(whole) - left_out


def test_a_joint_with_a_roller_misses_nothing_without_ezdxf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    done = layflat("joint", "design", "rig-polyester", "--out", tmp_path)
    assert (done.exit_code, done.stderr) == (0, "")
    assert not written(tmp_path)


def test_size_names_the_file_and_the_command_that_tunes_it(tmp_path: Path) -> None:
    done = layflat(*SIZE, "--link-length", "300 mm", "--name", "wrist", "--out", tmp_path)
    assert done.exit_code == 0, done.exception
    path = tmp_path / "wrist.toml"
    assert f"layflat tune {path}" in done.stdout
    machine = load(path)
    assert machine.name == "wrist"
    assert machine.joint["small"].planar_link.length == pytest.approx(0.3)


@pytest.mark.parametrize("name", [" ", "../../evil", "/abs/path", "nul\0"])
def test_a_name_that_leaves_the_folder_is_refused(name: str, tmp_path: Path) -> None:
    assert refused(*SIZE, "--name", name, "--out", tmp_path / "out").startswith("--name: ")
    assert not (tmp_path / "out").exists()


def table(folder: Path) -> Path:
    path = folder / "measured.csv"
    path.write_text(
        "angle_deg,torque_Nm\n" + "".join(f"{a},{80 - a / 4}\n" for a in range(0, 140, 10)), encoding="utf-8"
    )
    return path


def test_a_measured_table_belongs_to_one_joint(tmp_path: Path) -> None:
    given = (
        "joint",
        "design",
        "paper-arm",
        "--table",
        table(tmp_path),
        "--pressure",
        "3 bar",
        "--out",
        tmp_path / "out",
    )
    assert refused(*given) == "--table: measures one joint; add --joint large or --joint small"
    done = layflat(*given, "--joint", "large")
    assert done.exit_code == 0, done.exception
    assert "paper-arm, large joint" in done.stdout
    assert "small joint" not in done.stdout


def test_options_that_would_be_ignored_are_refused(tmp_path: Path) -> None:
    assert refused("joint", "design", "paper-arm", "--pressure", "3 bar").startswith("--pressure: needs --table")
    given = ("joint", "design", "paper-arm", "--joint", "large", "--table", table(tmp_path))
    assert "measured.csv: pressure: is missing" in refused(*given)
    assert "--pressure: ' ' " in refused(*given, "--pressure", " ")
    for high in ("500 bar", "0 bar", "-3 bar"):
        assert "give the gauge pressure of the test, 0.01 bar to 100 bar" in refused(*given, "--pressure", high)


@pytest.mark.parametrize("name", [" ", "3", "Large"])
def test_an_unknown_joint_is_refused(name: str) -> None:
    assert (
        refused("joint", "design", "paper-arm", "--joint", name)
        == f"--joint: unknown joint {name!r}; give large or small"
    )
