"""Drawings: the DXF's polygon is the envelope, files are whole, and the outline can be cut."""

from __future__ import annotations

import csv
import subprocess
import sys
from functools import cache
from itertools import combinations
from math import pi, radians
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import ezdxf.filemanagement
import numpy as np
import pytest

from layflat.design import (
    JointDesign,
    SizingRequest,
    cam_outline,
    cam_sheet,
    cylinder_characteristic,
    design_joint,
    layout_sheet,
    size_joint,
    straplines,
    synthesise,
    write_drawings,
)
from layflat.design.cam import HUB_SHARE
from layflat.design.sheet import Sheet, dxf_text, svg_text
from layflat.errors import DesignError, MissingExtraError, OutputError
from layflat.machine import load
from tests.design.rolled_cam import Shell

ARM = load("paper-arm")
Box = np.ndarray[Any, np.dtype[np.float64]]
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


@cache
def sheets() -> list[tuple[JointDesign, Sheet]]:
    """Cams and layouts of the arm's joints, of a drum with deflecting roller, and of joints of unusual size."""
    drum = load("rig-shell-steel")
    joint = drum.joint["small"]
    rolled = joint.model_copy(update={"output": joint.output.model_copy(update={"kind": "cam"})})
    designs = [
        *(design_joint(ARM, name) for name in ARM.joints),
        design_joint(drum.model_copy(update={"joint": {"small": rolled}})),
        size_joint(SizingRequest(8.0, radians(90), 2.5e5)).design,
        size_joint(SizingRequest(300.0, radians(150), 7e5)).design,
    ]
    return [(design, draw(design)) for design in designs for draw in (cam_sheet, layout_sheet)]


def test_no_text_covers_another() -> None:
    for _, sheet in sheets():
        boxes = text_boxes(svg_text(sheet))
        assert len(boxes) > 5
        for (one, a), (other, b) in combinations(boxes, 2):
            assert (a[0] >= b[1]).any() or (b[0] >= a[1]).any(), f"{sheet.title}: {one!r} covers {other!r}"


def text_boxes(svg: str) -> list[tuple[str, Box]]:
    """Each text of an SVG, with the lower and upper corner of the box that it takes, a little less than its height."""
    found = []
    for element in ElementTree.fromstring(svg).iter(f"{SVG}text"):
        height, text = float(element.attrib["font-size"]), element.text or ""
        at = np.array([float(element.attrib["x"]), -float(element.attrib["y"])])
        turned = -radians(float(element.attrib["transform"].removeprefix("rotate(").split()[0]))
        long, high = 0.5 * height * len(text), 0.7 * height
        first = -0.5 * long if element.attrib["text-anchor"] == "middle" else 0.0
        corners = np.array([[first, 0.0], [first + long, 0.0], [first, high], [first + long, high]])
        c, s = np.cos(turned), np.sin(turned)
        placed = at + corners @ np.array([[c, s], [-s, c]])
        found.append((text, np.array([placed.min(axis=0), placed.max(axis=0)])))
    return found


def test_dimension_lines_of_a_cam_stay_clear_of_each_other_and_of_the_part() -> None:
    for _, sheet in sheets()[::2]:
        part = sheet.paths[0].points
        *levers, width, height = sheet.distances
        for distance in (width, height):
            overall = distance.ends
            axis = 1 if distance is width else 0
            others = np.vstack([part, *(lever.ends for lever in levers)])[:, axis]
            assert abs(overall[:, axis] - others[:, None]).min() > 2 * sheet.text_height
            measured = float(np.hypot(*(overall[1] - overall[0])))
            assert distance.label == f"{measured:.2f}"


def test_layout_has_dimensions_and_says_what_each_kind_of_line_is(design: JointDesign) -> None:
    sheet, joint = layout_sheet(design), design.joint
    assert [d.label for d in sheet.diameters] == [f"⌀{joint.cylinder.diameter * 1e3:.4g}"]
    assert [d.label for d in sheet.distances] == [f"{joint.output.shaft_offset * 1e3:.4g}"]
    texts = " ".join(note.text for note in sheet.notes)
    for word in ("cam", "strap", "shell", "cylinder", "hose", "mm", design.name):
        assert word in texts
    samples = [path for path in sheet.paths if (path.points[:, 1] == path.points[0, 1]).all() and len(path.points) == 2]
    drawn = {path.layer for path in sheet.paths}
    assert drawn == {"OUTLINE", "CENTRE", "STRAP", "HOSE"} == {path.layer for path in samples[-4:]}
    straps = [path for path in sheet.paths if path.layer == "STRAP"]
    assert len(straps) == 3 + 1


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
    cam = synthesise(cylinder_characteristic(joint), straplines.joint_strap_line(joint), radians(420))
    with pytest.raises(DesignError, match="turns back over itself"):
        cam_outline(cam)


def test_a_round_roller_has_no_cam_to_draw(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r'output\.kind: "roller" has no cam; give "cam"'):
        write_drawings(design_joint("rig-polyester"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_nothing_is_written_where_a_file_is_in_the_way(design: JointDesign, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.raises(OutputError, match="can't write here"):
        write_drawings(design, tmp_path / "file")


def test_without_ezdxf_all_is_written_but_the_dxf(
    design: JointDesign, drawn: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    files = write_drawings(design, tmp_path / "out")
    assert [file.name for file in files] == [file.name for file in drawn if file.suffix != ".dxf"]
    assert [file.read_bytes() for file in files] == [file.read_bytes() for file in drawn if file.suffix != ".dxf"]
    with pytest.raises(MissingExtraError, match=r"DXF drawing: needs ezdxf, .*pip install 'layflat\[drawing\]'"):
        dxf_text(cam_sheet(design))


def test_ezdxf_is_not_imported_with_the_package() -> None:
    code = "import sys, layflat.design; sys.exit('ezdxf' in sys.modules or 'matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_files_are_named_without_spaces(tmp_path: Path) -> None:
    path = tmp_path / "odd.toml"
    path.write_text('extends = "paper-small-joint"\nname = "my arm (2)"\n', encoding="utf-8")
    files = write_drawings(design_joint(path), tmp_path / "out")
    assert {file.parent for file in files} == {tmp_path / "out"}
    assert files[0].name == "my-arm-2-small-cam.dxf"
