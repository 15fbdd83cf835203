"""Drawings: the DXF's polygon is the envelope, files are whole, and the outline can be cut."""

from __future__ import annotations

import builtins
import csv
import subprocess
import sys
from math import pi, radians
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import ezdxf.filemanagement
import numpy as np
import pytest
from rolled_cam import Shell

from layflat.design import JointDesign, cam_outline, design_joint, of_cylinder, straplines, synthesise, write_drawings
from layflat.design.outline import HUB_SHARE
from layflat.errors import DesignError, OutputError
from layflat.machine import load

ARM = load("paper-arm")
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module", params=["large", "small"])
def design(request: pytest.FixtureRequest) -> JointDesign:
    return design_joint(ARM, request.param)


@pytest.fixture(scope="module")
def drawn(design: JointDesign, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return write_drawings(design, tmp_path_factory.mktemp("drawn") / "new")


def polygon(path: Path) -> np.ndarray[Any, np.dtype[np.float64]]:
    space = ezdxf.filemanagement.readfile(path).modelspace()
    (outline,) = space.query('LWPOLYLINE[layer=="OUTLINE"]')
    assert outline.closed  # type: ignore[attr-defined]
    return np.array([point[:2] for point in outline.get_points()])  # type: ignore[attr-defined]


def test_dxf_polygon_agrees_with_the_envelope_to_a_micrometre(design: JointDesign, drawn: list[Path]) -> None:
    points, shell, cam = polygon(drawn[0]) * 1e-3, Shell(design.joint), design.with_cam()
    for s in np.linspace(0.0, shell.full_travel, 23):
        lever, psi = shell.line(float(s))
        normal = psi - float(np.interp(s, cam.travel, cam.angle))
        reach = float((points @ np.array([np.cos(normal), np.sin(normal)])).max())
        assert reach == pytest.approx(lever, abs=1e-6)


def test_polygon_is_fine_enough_between_its_corners(design: JointDesign) -> None:
    cam = design.with_cam()
    sagitta = cam.curvature_radius[1:] * np.diff(-cam.normal) ** 2 / 8
    assert sagitta.max() < 0.1e-6


def test_dxf_is_valid_in_millimetres_with_real_dimensions(drawn: list[Path]) -> None:
    document = ezdxf.filemanagement.readfile(drawn[0])
    assert not document.audit().errors
    assert document.units == ezdxf.units.MM
    space = document.modelspace()
    assert len(space.query("DIMENSION")) == 5
    assert len(space.query('CIRCLE[layer=="OUTLINE"]')) == 1


def test_dimensions_measure_what_they_say(design: JointDesign, drawn: list[Path]) -> None:
    cam = design.with_cam()
    wanted = {f"{lever * 1e3:.3f}": lever * 1e3 for lever in (cam.lever[0], cam.lever[-1])}
    space = ezdxf.filemanagement.readfile(drawn[0]).modelspace()
    measured = {d.dxf.text: d.get_measurement() for d in space.query("DIMENSION")}  # type: ignore[attr-defined]
    for text, value in wanted.items():
        assert measured[text] == pytest.approx(value, abs=1e-6)


def test_svg_is_true_to_scale_and_holds_the_outline(design: JointDesign, drawn: list[Path]) -> None:
    root = ElementTree.parse(drawn[1]).getroot()
    left, top, width, height = (float(v) for v in root.attrib["viewBox"].split())
    sizes = [float(root.attrib[side].removesuffix("mm")) for side in ("width", "height")]
    assert sizes == pytest.approx([width, height], abs=2e-3)
    paths = [e.attrib["d"] for e in root.iter(f"{SVG}path") if e.attrib["class"] == "outline"]
    points = np.array([[float(v) for v in step.split(",")] for step in paths[0].strip("MZ").split(" L")])
    assert design.outline is not None
    np.testing.assert_allclose(points * [1, -1], design.outline.points * 1e3, atol=1e-4)
    assert (points > [left, top]).all()
    assert (points < [left + width, top + height]).all()
    texts = [e.text for e in root.iter(f"{SVG}text")]
    assert any(text and "N m at 4 bar" in text for text in texts)


def test_csv_holds_the_columns(design: JointDesign, drawn: list[Path]) -> None:
    with drawn[2].open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    torque = np.array([float(row["torque_Nm"]) for row in rows])
    np.testing.assert_allclose(torque, design.mean_torque, rtol=1e-8)
    assert float(rows[-1]["cam_angle_deg"]) == pytest.approx(np.degrees(design.stroke))


def test_layout_is_a_picture(drawn: list[Path]) -> None:
    root = ElementTree.parse(drawn[3]).getroot()
    assert len([e for e in root.iter(f"{SVG}path") if e.attrib["class"] == "strap"]) == 3


def test_layout_of_a_drum_shows_its_roller(tmp_path: Path) -> None:
    path = tmp_path / "drum.toml"
    path.write_text(
        'extends = "rig-shell-steel"\nname = "drum"\n[joint.small.output]\nkind = "cam"\n', encoding="utf-8"
    )
    files = write_drawings(design_joint(path), tmp_path / "out")
    assert all(file.exists() for file in files)


def test_outline_keeps_profile_hub_and_clamp(design: JointDesign) -> None:
    outline = design.outline
    assert outline is not None
    np.testing.assert_array_equal(outline.profile, design.with_cam().profile[::-1])
    steps = np.diff(np.vstack((outline.points, outline.points[:2])), axis=0)
    turns = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    assert (turns > -1e-12).all()
    assert np.hypot(*outline.points.T).min() >= HUB_SHARE * outline.bore / 2 * np.cos(pi / 180) - 1e-9
    assert (np.abs(outline.points - outline.clamp_end).sum(axis=1) < 1e-12).any()
    assert 0 < outline.area < pi * np.hypot(*outline.points.T).max() ** 2


@pytest.mark.parametrize("bore", [0.0, -0.01, 0.03, float("nan")])
def test_a_bore_that_leaves_no_wall_is_refused(bore: float) -> None:
    with pytest.raises(DesignError, match=r"a bore of .* below [\d.]+ mm, for the smallest lever arm"):
        design_joint(ARM, "large", bore=bore)


def test_a_profile_that_turns_over_itself_is_refused() -> None:
    joint = ARM.joint["small"]
    cam = synthesise(of_cylinder(joint), straplines.of_joint(joint), radians(420))
    with pytest.raises(DesignError, match="turns back over itself"):
        cam_outline(cam)


def test_a_round_roller_has_no_cam_to_draw(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r'output\.kind: "roller"; give "cam"'):
        write_drawings(design_joint("rig-polyester"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_nothing_is_written_where_a_file_is_in_the_way(design: JointDesign, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.raises(OutputError, match="can't write here"):
        write_drawings(design, tmp_path / "file")


def test_without_ezdxf_nothing_is_written(design: JointDesign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.startswith("ezdxf"):
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(OutputError, match=r"needs ezdxf; pip install 'layflat\[drawing\]'"):
        write_drawings(design, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_ezdxf_is_not_imported_with_the_package() -> None:
    code = "import sys, layflat.design; sys.exit('ezdxf' in sys.modules or 'matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_names_that_are_no_file_names_stay_in_the_folder(tmp_path: Path) -> None:
    path = tmp_path / "odd.toml"
    path.write_text('extends = "paper-small-joint"\nname = "../my arm/2"\n', encoding="utf-8")
    files = write_drawings(design_joint(path), tmp_path / "out")
    assert {file.parent for file in files} == {tmp_path / "out"}
    assert files[0].name == "..-my-arm-2-small-cam.dxf"
