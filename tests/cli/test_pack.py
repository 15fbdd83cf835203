from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from layflat.cell import load
from layflat.cell.work.observer import Delivery, Verdict, VisionErrors
from layflat.cli import app
from layflat.cli.pack_run import PackRequest, _run_and_report, nothing_packed
from layflat.errors import CameraError, CellError, InputError, MissingExtraError
from layflat.pages.cell.link import PageLink
from layflat.pages.cell.snapshot import RunSnapshot
from tests.cli.commands import refused
from tests.cli.few_tomatoes import FEW
from tests.lerobot import reading

pytest.importorskip("mujoco")

from layflat.cell.work.run import PackingRun  # needs it

MOVED = """\
extends = "few.toml"

[camera]
position = ["305 mm", "370 mm", "1500 mm"]
looks_at = ["305 mm", "370 mm", "0 mm"]
"""


@pytest.fixture
def few(tmp_path: Path) -> str:
    path = tmp_path / "few.toml"
    path.write_text(FEW, encoding="utf-8")
    return str(path)


def test_cells_are_listed_and_printed() -> None:
    assert "packing" in CliRunner().invoke(app, ["cell", "list"]).output
    printed = CliRunner().invoke(app, ["cell", "show", "packing"]).output
    assert printed.startswith('name = "packing"\n')
    assert isinstance(CliRunner().invoke(app, ["cell", "show", "paking"]).exception, CellError)


@pytest.mark.usefixtures("opengl")
def test_a_run_leaves_results_a_film_and_a_sheet(few: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = CliRunner().invoke(app, ["cell", "pack", "--cell", few, "--picks", "1", "--out", str(out), "--film", "gif"])
    assert done.exception is None, done.output
    written = {line.removeprefix("wrote ") for line in done.output.splitlines() if line.startswith("wrote ")}
    assert written == {str(path) for path in out.iterdir()}
    assert "1 of 1 pick correct: in the chosen place, of its kind and grade (100.0%)" in done.output
    assert max(len(line) for line in done.output.splitlines() if "wrote" not in line) <= 110
    assert {path.name for path in out.iterdir()} == {"calibration.toml", "film.gif", "results.json", "sheet.png"}
    assert json.loads((out / "results.json").read_text(encoding="utf-8"))["summary"]["correct"] == 1

    # The same camera again, moved by 5 mm.
    moved = tmp_path / "moved.toml"
    moved.write_text(MOVED, encoding="utf-8")
    known = ["--calibration", str(out / "calibration.toml")]
    refused = CliRunner().invoke(app, ["cell", "pack", "--cell", str(moved), *known, "--out", str(tmp_path / "moved")])
    assert isinstance(refused.exception, CameraError)


def test_a_run_leaves_a_lerobot_data_set(few: str, tmp_path: Path) -> None:
    asked = ["cell", "pack", "--cell", few, "--picks", "1", "--out", str(tmp_path / "out"), "--film", "none"]
    done = CliRunner().invoke(
        app, [*asked, "--lerobot", str(tmp_path / "data"), "--lerobot-fps", "25"], env={"MUJOCO_GL": "nothing"}
    )
    assert done.exception is None, done.output
    assert f"wrote {tmp_path / 'data'}" in done.output.splitlines()
    assert len(reading.episodes(tmp_path / "data")) == 1
    assert reading.info(tmp_path / "data")["fps"] == 25


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["--lerobot", "data", "--lerobot-fps", "30"],
            "--lerobot-fps: 30 frames a second fall between control cycles of 5 ms",
        ),
        (["--lerobot-fps", "20"], "--lerobot-fps: is for a data set; add --lerobot, or leave it out"),
        (["--lerobot", "data", "--study"], "--lerobot: cannot be combined with --study; leave one of them out"),
        (["--lerobot", "./out", "--out", "out"], "--lerobot: is the folder of the other results; give one of its own"),
        (["--lerobot", "."], ".: is not empty, it holds 'few.toml'; give a new folder"),
        (["--lerobot", "few.toml"], "few.toml: is no folder; give the name of a new folder"),
    ],
)
def test_a_data_set_that_can_not_be_made_is_refused_before_the_run(few: str, words: list[str], said: str) -> None:
    assert said in refused("cell", "pack", "--cell", "few.toml", *words, cwd=Path(few).parent)


def test_a_missing_package_is_named_before_the_run(few: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    failed = CliRunner().invoke(app, ["cell", "pack", "--cell", few, "--lerobot", "data"])
    assert isinstance(failed.exception, MissingExtraError)
    assert "layflat[logs]" in str(failed.exception)


def test_a_study_has_a_row_for_each_seed(few: str, tmp_path: Path) -> None:
    asked = ["cell", "pack", "--cell", few, "--study", "--seeds", "2", "--picks", "1", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, asked, env={"MUJOCO_GL": "nothing"})
    assert done.exception is None, done.output
    assert "2 of 2 picks" in done.output
    runs = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))["runs"]
    assert [run["seed"] for run in runs] == [0, 1]


STOPPED = """\
import os, signal, sys, threading
from layflat.cell.work import run

def stop_after_the_first(*asked, **named):
    runs = run_all(*asked, **named)
    yield next(runs)
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    yield from runs

run_all, run.run_seeds = run.run_seeds, stop_after_the_first
if __name__ == "__main__":
    from layflat.cli import main
    main()
"""


def test_a_study_that_is_stopped_keeps_its_runs_and_marks_them_partial(few: str, tmp_path: Path) -> None:
    script, out = tmp_path / "stopped.py", tmp_path / "out"
    script.write_text(STOPPED, encoding="utf-8")
    asked = ["cell", "pack", "--cell", few, "--study", "--seeds", "40", "--picks", "1", "--out", str(out)]
    done = subprocess.run(
        [sys.executable, str(script), *asked], env=os.environ | {"MUJOCO_GL": "nothing"},
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 130, done.stderr
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert results["partial"] is True
    assert 1 <= len(results["runs"]) < 40
    told = done.stderr.splitlines()[-1]
    assert (
        told
        == f"layflat: stopped after {len(results['runs'])} of 40 seeds; partial results are in {out / 'results.json'}"
    )
    assert "Traceback" not in done.stderr


def test_without_opengl_it_goes_on_without_pictures(few: str, tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-c",
        "from layflat.cli import main; main()",
        "cell",
        "pack",
        "--cell",
        few,
        "--picks",
        "1",
    ]
    done = subprocess.run(
        [*command, "--out", str(tmp_path / "out")], env=os.environ | {"MUJOCO_GL": "nothing"},
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6)" in done.stderr
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"results.json"}
    assert "1 of 1 pick correct" in done.stdout


@pytest.mark.usefixtures("opengl")
def test_an_empty_tray_is_told_after_the_results_are_written(few: str, tmp_path: Path) -> None:
    empty = tmp_path / "empty.toml"
    empty.write_text('extends = "few.toml"\n[tray.infeed]\ncount = { min = 0, max = 0 }\n', encoding="utf-8")
    out = tmp_path / "out"
    done = CliRunner().invoke(app, ["cell", "pack", "--cell", str(empty), "--out", str(out)])
    assert isinstance(done.exception, CellError)
    assert "there is nothing in the trays; lay produce into them" in str(done.exception)
    assert {path.name for path in out.iterdir()} == {"calibration.toml", "film.mp4", "results.json", "sheet.png"}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--film", "avi"], "--film: unknown kind of film 'avi'; give mp4, gif, none"),
        (["--cell", "paking"], "paking: no such cell; did you mean 'packing'?"),
        (["--study", "--film", "gif"], "--film: cannot be combined with --study"),
        (["--seeds", "4"], "--seeds: is the number of a study's seeds; add --study"),
        (["--study", "--over", "sky"], "--over: 'sky' is nothing to pack over; give cloud"),
        (["--over", "cloud"], "--over: is for a study; add --study"),
        (["--calibration", "nowhere.toml"], "nowhere.toml: can't be read"),
        (["--watch", "--study"], "--watch: cannot be combined with --study"),
        (["--port", "9000"], "--port: is for the page; add --watch, or leave it out"),
        (["--no-browser"], "--no-browser: is for the page; add --watch"),
        (["--watch", "--host", "192.0.2.1"], "--host: '192.0.2.1' can be reached from other computers"),
        (["--watch", "--key", "none.pem"], "--certificate: is missing"),
    ],
)
def test_what_is_wrong_is_said_before_any_work(options: list[str], said: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["cell", "pack", *options, "--out", str(tmp_path / "out")])
    assert isinstance(done.exception, InputError)
    assert said in str(done.exception)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("content", [None, "", "picture_px = [1280", 'name = "packing"\n'])
@pytest.mark.parametrize("study", [[], ["--study", "--seeds", "2"]], ids=["run", "study"])
def test_a_wrong_calibration_is_refused_also_without_opengl(
    content: str | None, study: list[str], few: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    if content is not None:
        (tmp_path / "camera.toml").write_text(content, encoding="utf-8")
    command = ["cell", "pack", "--cell", few, *study, "--picks", "1", "--calibration", "camera.toml", "--out", "out"]
    assert refused(*command, cwd=tmp_path).startswith("layflat: camera.toml: ")
    assert not (tmp_path / "out").exists()


def test_a_port_in_use_is_named_before_any_work(few: str, tmp_path: Path) -> None:
    pytest.importorskip("nicegui")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        line = refused("cell", "pack", "--watch", "--cell", few, "--port", str(port), "--no-browser", cwd=tmp_path)
    assert line.startswith(f"layflat: --port: port {port} can't be had")


def test_a_page_needs_its_extra(few: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nicegui", None)
    line = refused("cell", "pack", "--watch", "--cell", few, "--no-browser", cwd=tmp_path)
    assert line == "layflat: --watch: needs nicegui, not installed; install it: pip install 'layflat[panel]'"
    assert not (tmp_path / "build").exists()


@pytest.mark.parametrize(("machine", "advised"), [("paper-arm-fast", True), ("paper-arm-tracking", False)])
def test_a_run_without_a_successful_pick_is_an_error_that_names_a_law_which_follows_no_belt(
    machine: str, advised: bool, tmp_path: Path
) -> None:
    file = tmp_path / "slow.toml"
    file.write_text(f'extends = "belt"\nname = "slow"\nmachine = "{machine}"\n', encoding="utf-8")
    cell = load(file)
    missed, placed = (
        Delivery(0, (), (Verdict(correct=correct),), (), (), 1.0, VisionErrors()) for correct in (False, True)
    )
    error = nothing_packed(cell, [PackingRun(cell, 0, (missed,), None)])
    assert error is not None
    assert "in cell 'slow'" in str(error)
    assert ("control law 'paper' does not follow a belt" in str(error)) == advised
    assert nothing_packed(cell, [PackingRun(cell, 0, (missed,), None), PackingRun(cell, 1, (placed,), None)]) is None


def test_a_page_shows_how_far_the_calibration_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Page:
        snapshot = RunSnapshot()
        show = PageLink.show

        def _post(self, _name: str, shot: RunSnapshot) -> None:
            shown.append(shot.calibrated)
            raise KeyboardInterrupt

    shown: list[float] = []
    monkeypatch.setattr("layflat.cli.pack_run.calibration_of", lambda *arguments: arguments[-1](0.5))
    request = PackRequest(load("packing"), 0, 1, tmp_path, "none")
    with pytest.raises(KeyboardInterrupt):
        _run_and_report(request, None, Page())  # type: ignore[arg-type]
    assert shown == [0.5]
