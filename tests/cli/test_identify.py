"""`layflat excite` and `layflat identify` as a person uses them."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from layflat.identify.identification import prepare_identification
from layflat.identify.report_text import write_page
from layflat.machine import load
from layflat.machine.listing import list_values
from layflat.machine.loader import tables
from layflat.motion.demand_file import read_demand
from layflat.sim import rollout
from layflat.sim.dataset import save_run
from tests.cli.commands import layflat, refused

REAL = """\
extends = "paper-small-joint"
name = "{name}"
[joint.small.brake]
torque = "{torque} N m"
viscous = "0.05 N m s/rad"
"""


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
        (folder / f"{name}.toml").write_text(REAL.format(name=name, torque=torque), encoding="utf-8")
    done = layflat("simulate", "real.toml", "--demand", "moves.csv", "--out", ".", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "rms error against moves.csv: small " in done.stdout
    far = load(folder / "far.toml")
    save_run(
        rollout(far, read_demand(far, folder / "moves.csv", 0.005).angles, duration=4.005, start=0.0), folder / "far.nc"
    )
    return folder


def test_a_sequence_that_a_machine_follows(tmp_path: Path) -> None:
    done = layflat("excite", "paper-arm", "--speed", "200 deg/s", "--seed", "3", "-o", "e.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "wrote e.csv: 42 s of steps" in done.stdout
    assert "layflat simulate paper-arm --demand e.csv" in done.stdout
    table = np.loadtxt(tmp_path / "e.csv", delimiter=",", skiprows=1)
    assert table.shape[1] == 3
    assert np.abs(np.diff(table[:, 1:], axis=0)).max() <= 200.0 * 0.005 + 1e-4


def test_arms_in_space_get_a_sequence_that_they_can_carry_out(tmp_path: Path) -> None:
    done = layflat("excite", "picking-arm", "-o", "e.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert read_demand(load("picking-arm"), tmp_path / "e.csv", 0.005).angles.shape[1] == 4
    heavy = 'extends = "picking-arm"\nname = "heavy"\n[arm]\npayload = "6 kg"\n'
    (tmp_path / "heavy.toml").write_text(heavy, encoding="utf-8")
    told = refused("excite", "heavy.toml", "-o", "h.csv", cwd=tmp_path)
    assert told.startswith(
        "layflat: --reach: joint 'wrist' can't move a payload of 6 kg against gravity at a reach of 0.3; give "
    )
    told = refused("tune", "heavy.toml", "--out", "out", cwd=tmp_path)
    assert told.startswith("layflat: heavy.toml: joint 'wrist' can't hold ")
    assert not (tmp_path / "h.csv").exists()


def test_a_machine_is_found_and_predicts_another_run(bench: Path) -> None:
    words = ("identify", "real.nc", "--machine", "paper-small-joint", "--fit", "friction", "--starts", "2")
    done = layflat(*words, "--out", "first", cwd=bench)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert max(map(len, done.stdout.splitlines()[:-4])) <= 100
    for said in (
        "Identified parameters",
        "joint.small.brake.torque",
        "Prediction errors",
        "are identified by the logs.",
    ):
        assert said in done.stdout
    assert "Validation: what was not fitted is predicted" in done.stdout
    names = [f"paper-small-joint-identified.{ending}" for ending in ("html", "json", "toml")]
    assert sorted(path.name for path in (bench / "first").iterdir()) == names

    session = prepare_identification([bench / "real.nc"], "paper-small-joint", bench / "again", blocks="friction")
    fitted = session.fit(starts=2)
    session.write_results(fitted)
    write_page(session, fitted, session.path.with_suffix(".html"))
    for name in names:
        assert (bench / "first" / name).read_bytes() == (bench / "again" / name).read_bytes()

    found = load(bench / "first" / names[2])
    assert found.joint["small"].brake.torque == pytest.approx(3.1, rel=0.02)
    source = found.provenance["joint.small.brake.torque"]
    values = json.loads((bench / "first" / names[1]).read_text(encoding="utf-8"))
    assert source.source == "identified"
    assert "95 %" in source.note
    assert f"real (sha256 {values['logs']['real'][:16]})" in source.note
    line = next(
        line for line in list_values(*tables(bench / "first" / names[2])) if line.path == "joint.small.brake.torque"
    )
    assert (line.source, line.note) == (source.source, source.note)

    # Another run: voltages that the fit never saw, from the same start.
    run = rollout(load(bench / "real.toml"), lambda t: [0.3 * np.sin(4.0 * t)], duration=2.0, start=0.0, seed=7)
    rows = run["voltage"].to_numpy()[:-1]
    angles = {
        name: rollout(machine, duration=2.0, start=0.0, noise=False, voltage=rows)["angle"]
        for name, machine in (
            ("found", found),
            ("before", load("paper-small-joint")),
            ("real", load(bench / "real.toml")),
        )
    }
    error = {name: float(np.sqrt(((angle - angles["real"]) ** 2).mean())) for name, angle in angles.items()}
    assert error["found"] < 0.2 * error["before"]


def test_a_value_that_hits_its_bound_is_reported_and_marked(bench: Path) -> None:
    words = ("identify", "far.nc", "--machine", "paper-small-joint", "--fit", "friction", "--starts", "0")
    done = layflat(*words, "--out", "marked", cwd=bench)
    assert done.returncode == 3
    assert done.stderr.startswith("layflat: not to be trusted: joint.small.brake.torque hit its bound")
    assert len(done.stderr.splitlines()) == 1
    assert "hit its bound" in done.stdout
    kept = load(bench / "marked" / "paper-small-joint-identified.toml")
    assert kept.title.startswith("not to be trusted: ")
    page = (bench / "marked" / "paper-small-joint-identified.html").read_text(encoding="utf-8")
    assert "<b>Not to be trusted:</b>" in page


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_an_interrupt_keeps_the_best_values_so_far(bench: Path) -> None:
    interrupted = (
        "import os, signal; from scipy import optimize; from layflat.cli import main; whole = optimize.least_squares\n"
        "def search(residuals, *args, **options):\n"
        "    residuals(args[0])\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "    return whole(residuals, *args, **options)\n"
        "optimize.least_squares = search; main()"
    )
    words = ("identify", "real.nc", "--machine", "paper-small-joint", "--fit", "friction", "--starts", "0")
    command = [sys.executable, "-c", interrupted, *words, "--out", "stopped"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=bench, check=False, timeout=300)
    assert done.returncode == 130, done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert "paper-small-joint-identified.toml" in done.stderr
    kept = load(bench / "stopped" / "paper-small-joint-identified.toml")
    assert kept.title.startswith("partial, stopped by the user: ")
    page = (bench / "stopped" / "paper-small-joint-identified.html").read_text(encoding="utf-8")
    assert "<b>Not to be trusted:</b>" in page


def test_a_fit_is_printed_and_kept_though_no_description_can_be_written(bench: Path) -> None:
    spoilt = (
        "from layflat.cli import main; from layflat.errors import MachineError\n"
        "from layflat.identify import identification\n"
        "whole = identification.write_identified\n"
        "def refuse(given, described, found, logs, path, replaces):\n"
        "    if found.simulations: raise MachineError('is no length', where=f'{path}: valve.lag', right='give one')\n"
        "    return whole(given, described, found, logs, path, replaces)\n"
        "identification.write_identified = refuse; main()"
    )
    words = ("identify", "real.nc", "--machine", "paper-small-joint", "--fit", "friction", "--starts", "0")
    command = [sys.executable, "-c", spoilt, *words, "--out", "spoilt"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=bench, check=False, timeout=300)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "the fitted values make no valid description" in done.stderr
    assert "all figures are in spoilt/paper-small-joint-identified.json" in done.stderr
    assert "joint.small.brake.torque" in done.stdout
    assert sorted(path.suffix for path in (bench / "spoilt").iterdir()) == [".html", ".json"]


def test_mistakes_give_one_line_and_status_2(bench: Path) -> None:
    (bench / "foreign.csv").write_text("t,theta\n0,1\n1,2\n2,3\n", encoding="utf-8")
    of = ("--machine", "paper-small-joint")
    for words, expected in (
        (
            ("foreign.csv", *of),
            "foreign.csv: its columns (t, theta) are not layflat's own signals; give a mapping file",
        ),
        (("real.nc", *of, "--seed", "-1"), "Invalid value for '--seed'"),
    ):
        done = layflat("identify", *words, cwd=bench)
        assert done.returncode == 2, words
        assert done.stderr.startswith(f"layflat: {expected}")
        assert len(done.stderr.splitlines()) == 1
        assert done.stdout == ""
