"""`layflat study run` as a person uses it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from layflat.study import read_study
from tests.cli.commands import layflat

STUDY = """
name = "brakes"
machine = "paper-small-joint"
sampling = "grid"

[scenario]
duration = "0.2 s"
demand = [["0 s", "-10 deg"], ["0.05 s", "10 deg"]]

[vary."joint.small.brake.torque"]
low = "0 N m"
high = "4 N m"
points = 5
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    return tmp_path


def test_a_study_its_summary_and_a_change(folder: Path) -> None:
    done = layflat("study", "run", "study.toml", "--out", "out", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "brakes: 5 samples, 5 runs" in done.stdout
    assert re.search(r"settling\.small\.0 +│ s ", done.stdout)
    assert "0 of 5 runs diverged" in done.stdout
    assert "wrote out/table.parquet and .csv" in done.stdout
    assert "wrote out/figure.svg and .png" in done.stdout
    header, *rows = (folder / "out" / "table.csv").read_text(encoding="utf-8").splitlines()
    assert "joint.small.brake.torque [N*m]" in header
    assert len(rows) == 5
    assert max(map(len, done.stdout.splitlines())) <= 100

    again = layflat("study", "run", "study.toml", "--out", "out", cwd=folder)
    assert (again.returncode, again.stdout) == (0, done.stdout)

    (folder / "study.toml").write_text(STUDY.replace('"4 N m"', '"3 N m"'), encoding="utf-8")
    changed = layflat("study", "run", "study.toml", "--out", "out", cwd=folder)
    assert changed.returncode == 2
    assert changed.stderr.splitlines() == [
        "layflat: out: holds a study that differs from this one;"
        " give another folder, or the study as it was, or --force to replace it",
        "  study.vary.joint.small.brake.torque.high: 4.0 N*m -> 3.0 N*m",
    ]


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("torque", "torqe", "no number of this name can vary; nearest is 'joint.small.brake.torque'"),
        ('"4 N m"', "4", "vary.joint.small.brake.torque.high: 4 is a bare number; give a torque such as"),
    ],
)
def test_a_mistake_gives_one_line(folder: Path, old: str, new: str, expected: str) -> None:
    (folder / "study.toml").write_text(STUDY.replace(old, new), encoding="utf-8")
    done = layflat("study", "run", "study.toml", "--out", "out", cwd=folder)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("layflat: study.toml: ")
    assert expected in line
    assert not (folder / "out").exists()


def test_a_built_in_study_prints_its_finding_and_draws_its_figure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for place in ("layflat.study", "layflat.experiments.questions"):
        monkeypatch.setattr(f"{place}.read_study", lambda name: read_study(name).thinned(3))
    done = layflat("study", "run", "supply-pressure", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    out = tmp_path / "build" / "study" / "supply-pressure"
    finding = (out / "finding.txt").read_text(encoding="utf-8")
    assert "N m per deg" in finding
    assert " ".join(finding.split()) in " ".join(done.stdout.split())
    assert (out / "figure.png").read_bytes()[:4] == b"\x89PNG"
    assert (out / "figure.svg").read_text(encoding="utf-8").startswith("<svg")
    assert max(map(len, done.stdout.splitlines())) <= 100
    again = layflat("study", "run", "supply-pressure", cwd=tmp_path)
    assert (again.returncode, again.stdout) == (0, done.stdout)


def test_built_in_studies_are_listed_and_can_be_started_from(tmp_path: Path) -> None:
    done = layflat("study", "list", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "supply-pressure" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100
    shown = layflat("study", "show", "valves", cwd=tmp_path)
    assert shown.stdout.startswith("# Which valve?")
    for words in (("study", "show", "valve"), ("study", "run", "valve")):
        refused = layflat(*words, cwd=tmp_path)
        assert refused.returncode == 2
        assert refused.stderr.splitlines() == ["layflat: valve: no such study; did you mean 'valves'?"]
    assert not (tmp_path / "build").exists()


STOPPED = """
import sys
from layflat.study import runs

def stopped(*words, **options):
    raise KeyboardInterrupt

runs.ensemble = stopped
sys.argv = ["layflat", "study", "run", "study.toml", "--out", "out"]
from layflat.cli import main
main()
"""


def test_a_stopped_study_says_how_to_go_on(folder: Path) -> None:
    words = [sys.executable, "-c", STOPPED]
    done = subprocess.run(words, capture_output=True, text=True, cwd=folder, check=False, timeout=300)
    assert done.returncode == 130
    assert done.stderr.splitlines() == ["layflat: stopped after 0 of 5 runs; partial results are in out"]
    assert (folder / "out" / "partial.txt").read_text() == "partial: 0 of 5 runs; the same command goes on from here\n"
    assert layflat("study", "run", "study.toml", "--out", "out", cwd=folder).returncode == 0
    assert not (folder / "out" / "partial.txt").exists()
