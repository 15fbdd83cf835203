"""`layflat excite` and `layflat identify` as a person uses them."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from layflat.machine import load
from layflat.sim import rollout

REAL = """\
extends = "paper-small-joint"
name = "real"
[joint.small.brake]
torque = "{torque} N m"
viscous = "0.05 N m s/rad"
"""


def layflat(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from layflat.cli import main; main()", *words]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, check=False, timeout=300)


def demand(path: Path, levels: list[float]) -> None:
    """A short sequence: what `layflat excite` writes takes 42 s."""
    time = 0.5 * np.arange(len(levels))
    table = np.stack([time, levels], axis=1)
    np.savetxt(path, table, delimiter=",", header="time [s],demand.small [deg]", comments="", fmt="%g")


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with logs of two machines that are not as described: one by little, one by far."""
    folder = tmp_path_factory.mktemp("bench")
    demand(folder / "moves.csv", [0, 20, -15, 25, -20, 5, 8, 0, 0])
    for name, torque in (("real", 3.1), ("far", 0.02)):
        (folder / f"{name}.toml").write_text(REAL.format(torque=torque), encoding="utf-8")
        done = layflat("simulate", f"{name}.toml", "--demand", "moves.csv", "--out", name, cwd=folder)
        assert done.returncode == 0, done.stderr
    return folder


def test_a_sequence_that_a_machine_follows(tmp_path: Path) -> None:
    done = layflat("excite", "paper-arm", "--speed", "200 deg/s", "--seed", "3", "-o", "e.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "wrote e.csv: 42 s of steps" in done.stdout
    assert "layflat simulate paper-arm --demand e.csv" in done.stdout
    table = np.loadtxt(tmp_path / "e.csv", delimiter=",", skiprows=1)
    assert table.shape[1] == 3
    assert np.abs(np.diff(table[:, 1:], axis=0)).max() <= 200.0 * 0.005 + 1e-4
    for words, expected in (
        (("rig-kevlar",), "layflat: rig-kevlar: controller: has no gains"),
        (("paper-arm", "--speed", "2"), "layflat: --speed: '2'"),
        (("paper-arm", "--reach", "0.7"), "layflat: reach: 0.7 is out of range; give a share of the stroke"),
    ):
        refused = layflat("excite", *words, cwd=tmp_path)
        assert refused.returncode == 2
        assert refused.stderr.startswith(expected)
        assert len(refused.stderr.splitlines()) == 1


def test_a_machine_is_found_and_predicts_another_run(bench: Path) -> None:
    words = ("identify", "real/real.nc", "--machine", "paper-small-joint", "--fit", "friction", "--starts", "2")
    done = layflat(*words, "--out", "first", cwd=bench)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert max(map(len, done.stdout.splitlines()[:-4])) <= 100
    for told in (
        "what the logs tell",
        "joint.small.brake.torque",
        "how well it predicts",
        "The logs tell all of 2 values.",
    ):
        assert told in done.stdout
    assert "What was not fitted is predicted: angle within" in done.stdout
    names = [f"paper-small-joint-identified.{ending}" for ending in ("html", "json", "toml")]
    assert sorted(path.name for path in (bench / "first").iterdir()) == names

    again = layflat(*words, "--out", "again", cwd=bench)
    assert again.returncode == 0
    for name in names:
        assert (bench / "first" / name).read_bytes() == (bench / "again" / name).read_bytes()

    found = load(bench / "first" / names[2])
    assert found.joint["small"].brake.torque == pytest.approx(3.1, rel=0.02)
    source = found.provenance["joint.small.brake.torque"]
    values = json.loads((bench / "first" / names[1]).read_text(encoding="utf-8"))
    assert source.source == "identified"
    assert "95 %" in source.note
    assert f"real (sha256 {values['logs']['real'][:16]})" in source.note
    shown = layflat("show", f"first/{names[2]}", cwd=bench)
    assert "identified" in shown.stdout
    assert "sha256" in shown.stdout

    # Another run: voltages that the fit never saw, from the same start.
    run = rollout(load(bench / "real.toml"), lambda t: [0.3 * np.sin(4.0 * t)], duration=2.0, start=0.0, seed=7)
    rows = run["voltage"].to_numpy()
    angles = {
        name: rollout(machine, np.zeros_like(rows), duration=2.0, start=0.0, noise=False, voltage=rows)["angle"]
        for name, machine in (
            ("found", found),
            ("before", load("paper-small-joint")),
            ("real", load(bench / "real.toml")),
        )
    }
    error = {name: float(np.sqrt(((angle - angles["real"]) ** 2).mean())) for name, angle in angles.items()}
    assert error["found"] < 0.2 * error["before"]


def test_a_value_at_the_end_of_its_range_is_told_and_marked(bench: Path) -> None:
    words = ("identify", "far/far.nc", "--machine", "paper-small-joint", "--fit", "friction", "--starts", "0")
    done = layflat(*words, "--out", "marked", cwd=bench)
    assert done.returncode == 3
    assert done.stderr.startswith("layflat: not to be trusted: joint.small.brake.torque ran into the end of its range")
    assert len(done.stderr.splitlines()) == 1
    assert "at the end of its range" in done.stdout
    kept = load(bench / "marked" / "paper-small-joint-identified.toml")
    assert kept.title.startswith("not to be trusted: ")
    page = (bench / "marked" / "paper-small-joint-identified.html").read_text(encoding="utf-8")
    assert "<b>Not to be trusted:</b>" in page


def test_mistakes_give_one_line_and_status_2(bench: Path) -> None:
    (bench / "foreign.csv").write_text("t,theta\n0,1\n1,2\n2,3\n", encoding="utf-8")
    log, of = "real/real.nc", ("--machine", "paper-small-joint")
    for words, expected in (
        (
            ("foreign.csv", *of),
            "foreign.csv: its columns (t, theta) are not layflat's own signals; give a mapping file",
        ),
        ((log, *of, "--fit", "bogus"), "--fit: 'bogus' is no block of this bench; choose of valve, hose"),
        ((log, "--machine", "paper-arm"), "real: has no angle of joint 'large'"),
        ((log, *of, "--out", "moves.csv"), "moves.csv/.layflat: can't write here"),
        ((log, *of, "--seed", "-1"), "Invalid value for '--seed'"),
        ((log, *of, "--mapping", "no.toml"), "no.toml: can't be read"),
    ):
        done = layflat("identify", *words, cwd=bench)
        assert done.returncode == 2, words
        assert done.stderr.startswith(f"layflat: {expected}")
        assert len(done.stderr.splitlines()) == 1
        assert done.stdout == ""


def test_measured_loops_of_a_rod(measured_data: Path, tmp_path: Path) -> None:
    folder, mapping = measured_data / "zillen", Path(__file__).parents[2] / "examples" / "logs" / "zillen.toml"
    logs = [str(folder / f"KDN_{bar}bar.csv") for bar in (1, 7, 5)]
    words = ("identify", *logs[:2], "--validate", logs[2], "--machine", "friction-rig", "--mapping", str(mapping))
    done = layflat(*words, "--starts", "4", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    errors = json.loads((tmp_path / "out" / "friction-rig-identified.json").read_text(encoding="utf-8"))["errors"]
    judged = next(error for error in errors if error["judged"])
    assert judged["log"] == "KDN_5bar"
    assert judged["rms"] < 0.05 * 16.4  # of the loop's height
    assert layflat("show", "out/friction-rig-identified.toml", cwd=tmp_path).returncode == 0
