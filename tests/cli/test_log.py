"""`layflat log` as a person uses it."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from layflat.sim import rollout
from layflat.sim.dataset import save_run
from tests.cli.commands import layflat


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log that needs a mapping, and a run."""
    folder = tmp_path_factory.mktemp("rig")
    moves = [("0 s", "0 deg"), ("0.4 s", "35 deg"), ("1.4 s", "-40 deg")]
    run = rollout("paper-small-joint", moves, duration="2.5 s")
    save_run(run, folder / "run.nc")
    one = run.sel(joint="small")
    table = np.stack([1e3 * run["time"], np.degrees(one["measured_angle"]), one["voltage"]], axis=1)
    header = "t [ms],theta [deg],valve [V]"
    np.savetxt(folder / "rig.csv", table, delimiter=",", header=header, comments="", fmt="%.9g")
    return folder


def test_a_run_is_checked_without_a_mapping(rig: Path) -> None:
    done = layflat("log", "check", "run.nc", "--machine", "paper-small-joint", cwd=rig)
    assert done.returncode == 0, done.stderr
    assert "run.nc: 501 instants, one every 5 ms" in done.stdout
    assert "measured_angle.small" in done.stdout
    assert done.stdout.rstrip().endswith("run.nc: sound")
    assert max(map(len, done.stdout.splitlines())) <= 100


def test_a_guess_is_written_looked_through_and_used(rig: Path) -> None:
    done = layflat("log", "map", "rig.csv", "--machine", "paper-small-joint", cwd=rig)
    assert done.returncode == 0, done.stderr
    assert "wrote rig-mapping.toml: a guess, correct it before you use it" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100
    place = rig / "rig-mapping.toml"
    place.write_text(place.read_text() + "# looked through\n")
    again = layflat("log", "map", "rig.csv", cwd=rig)
    assert again.returncode == 2
    assert again.stderr.startswith("layflat: rig-mapping.toml: ")
    assert place.read_text().endswith("# looked through\n")
    words = ("log", "check", "rig.csv", "--mapping", "rig-mapping.toml", "--machine", "paper-small-joint")
    checked = layflat(*words, "--cycle", "10 ms", cwd=rig)
    assert checked.returncode == 0, checked.stderr
    assert "251 instants, one every 10 ms" in checked.stdout


@pytest.mark.compiled
def test_columns_of_an_arm_of_four_joints_are_guessed_by_number_or_name(tmp_path: Path) -> None:
    goal = {"base": "30 deg", "shoulder": "-20 deg", "elbow": "25 deg", "wrist": "-30 deg"}
    rest = dict.fromkeys(goal, "0 deg")
    run = rollout("picking-arm", [("0 s", rest), ("0.3 s", goal), ("1.2 s", rest)], duration="2 s")
    joints = [str(name) for name in run["joint"].to_numpy()]
    for style, names in (("number", "1234"), ("name", joints)):
        columns, header = [run["time"].to_numpy()], ["t"]
        for joint, name in zip(joints, names, strict=True):
            one = run.sel(joint=joint)
            angle, voltage, pressure = (
                one[key].to_numpy() for key in ("measured_angle", "voltage", "measured_pressure")
            )
            columns += [np.degrees(angle), voltage, 1e-5 * pressure]
            header += [f"q_{name}_deg", f"u_{name}", f"dp_{name}_bar"]
        log = f"{style}.csv"
        np.savetxt(tmp_path / log, np.stack(columns, 1), delimiter=",", header=",".join(header), comments="")
        assert layflat("log", "map", log, "--machine", "picking-arm", cwd=tmp_path).returncode == 0
        words = ("log", "check", log, "--mapping", f"{style}-mapping.toml", "--machine", "picking-arm")
        checked = layflat(*words, cwd=tmp_path)
        assert checked.returncode == 0, checked.stderr
        for joint in joints:
            assert all(joint in checked.stdout and signal in checked.stdout for signal in ("angle", "voltage"))


def test_errors_are_listed_and_refuse_the_log(rig: Path) -> None:
    text = (
        '[time]\ncolumn = "t [ms]"\nunit = "ms"\n'
        '[[column]]\nfrom = "theta [deg]"\nsignal = "angle"\njoint = "small"\nunit = "rad"\n'
    )
    (rig / "wrong.toml").write_text(text, encoding="utf-8")
    words = ("log", "check", "rig.csv", "--mapping", "wrong.toml", "--machine", "paper-small-joint")
    done = layflat(*words, cwd=rig)
    assert done.returncode == 2
    assert "angle.small" in done.stdout
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("layflat: rig.csv: angle.small: ")
    assert lines[0].endswith('unit = "deg" instead of "rad" would fit (factor 0.01745)')
    assert max(map(len, done.stdout.splitlines())) <= 100


def test_help_of_the_group_loads_nothing_heavy() -> None:
    code = (
        "import sys; from layflat import cli\n"
        "try: cli.app(['log', '--help'], standalone_mode=False)\n"
        "except SystemExit: pass\n"
        "print(sorted({'numba', 'numpy', 'xarray', 'mcap', 'pyarrow'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().splitlines()[-1] == "[]"
    assert "check" in done.stdout


def test_counts_of_a_channel_add_up_to_the_instants_of_the_log(tmp_path: Path) -> None:
    """A signal that is sampled half as often is filled in between: samples, filled and missing are all instants."""
    time = np.arange(600) * 0.005
    rows = [
        f"{t:.3f},{np.sin(t):.6f},{f'{2e5 + 1e5 * np.cos(t):.6f}' if i % 2 == 0 else ''}" for i, t in enumerate(time)
    ]
    (tmp_path / "half.csv").write_text("time,angle.small,pressure_a.small\n" + "\n".join(rows) + "\n", encoding="utf-8")
    done = layflat("log", "check", "half.csv", cwd=tmp_path)
    assert "half.csv: 600 instants" in done.stdout
    assert "300 + 299" in done.stdout
    assert "1 of 600 instants (0.17 %) are" in " ".join(done.stdout.replace("│", " ").split())
