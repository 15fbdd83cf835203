from pathlib import Path

import pytest

from layflat.machine import load
from tests.bridge.robot_files import UPPER, urdf, written
from tests.cli.commands import layflat, refused


def test_an_arm_is_exported_and_imported(tmp_path: Path) -> None:
    out = tmp_path / "arm.urdf"
    assert layflat("arm", "export", "paper-arm", "--out", str(out)).stdout == f"wrote {out}\n"
    done = layflat("arm", "import", str(out), "--name", "back", "--out", str(tmp_path / "to"))
    assert done.returncode == 0, done.stderr
    assert "tip at tool, 1.5 kg there" in " ".join(done.stdout.split())
    assert done.stdout.endswith(f"wrote {tmp_path / 'to' / 'back.toml'}\n")
    assert load(tmp_path / "to" / "back.toml").arm.kind == "chain"


def test_an_export_beside_its_description_leaves_the_meshes_of_that_alone(tmp_path: Path) -> None:
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
    (tmp_path / "plate.stl").write_text(f"solid\n{facet}endsolid\n", encoding="utf-8")
    mesh = '<visual><geometry><mesh filename="plate.stl"/></geometry></visual></link>'
    file = written(tmp_path, urdf(upper=UPPER.replace("</link>", mesh)))
    assert layflat("arm", "import", str(file), "--name", "plate", "--out", str(tmp_path)).returncode == 0
    mesh_of_description = tmp_path / "plate-meshes" / "plate.stl"
    before = mesh_of_description.read_bytes()
    for suffix in ("xml", "urdf"):
        done = layflat("arm", "export", str(tmp_path / "plate.toml"), "--out", str(tmp_path / f"plate.{suffix}"))
        assert done.returncode == 0, done.stderr
    assert mesh_of_description.read_bytes() == before


def test_options_of_an_import_are_taken(tmp_path: Path) -> None:
    file = written(tmp_path, urdf())
    words = ["--to", "lower", "--tool", "lower", "--joints", "elbow=paper-arm:large", "--no-meshes"]
    words += ["--stroke", "elbow=-10 deg, 70 deg", "--gravity", "0, 2 m/s^2, -9 m/s^2", "--out", str(tmp_path)]
    words += ["--package", f"any={tmp_path}"]
    done = layflat("arm", "import", str(file), *words)
    assert done.returncode == 0, done.stderr
    machine = load(tmp_path / "two.toml")
    assert machine.arm.gravity == (0.0, 2.0, -9.0)
    assert machine.arm.tool == (0.0, 0.0, 0.0)
    assert machine.joints["elbow"].hose == load("paper-arm").joints["large"].hose
    (row,) = [line.split() for line in done.stdout.splitlines() if line.strip().startswith("elbow")]
    assert row[2] == "30.0"


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--stroke", "elbow"], "--stroke: 'elbow' has no joint with two limits, the lower first; give such as"),
        (["--stroke", "elbow=1 deg, 0 deg"], "--stroke: 'elbow=1 deg, 0 deg' has no joint with two limits"),
        (["--stroke", "elbow=1, 2"], "--stroke: '1' is a bare number; give an angle such as \"120 deg\""),
        (["--gravity", "0, 1"], "--gravity: '0, 1' has 2 values; give \"0, 0, -9.81 m/s^2\""),
        (["--gravity", "0, 0, 9.81"], "--gravity: '9.81' is a bare number"),
        (["--to", "hand"], "--to: there is no link 'hand'"),
        (["--gravity", "-,.,+"], "--gravity: '-'"),
        (["--gravity", "0, ., -9 m/s^2"], "--gravity: '.'"),
        (["--stroke", "=0 deg, 1 deg"], "--stroke: '=0 deg, 1 deg' has no joint with two limits"),
        (["--stroke", "elbow=0 deg, 1 deg", "--stroke", "elbow=0 deg, 2 deg"], "--stroke: 'elbow' is given twice"),
        (["--package", "x"], "--package: 'x' names no folder; give NAME=FOLDER, such as my_robot=../my_robot"),
        (["--package", "x=none"], "--package: there is no folder 'none'; give the package's own folder"),
        (["--package", "x=.", "--package", "x=.."], "--package: 'x' is given twice; give it once"),
    ],
)
def test_mistakes_leave_nothing(words: list[str], expected: str, tmp_path: Path) -> None:
    file = written(tmp_path, urdf())
    assert refused("arm", "import", str(file), *words, "--out", str(tmp_path / "to")).startswith(f"layflat: {expected}")
    assert [path.name for path in tmp_path.iterdir()] == ["robot.urdf"]
