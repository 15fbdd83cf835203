from __future__ import annotations

from pathlib import Path

import pytest

from layflat.cell.vision import OnnxDetector
from layflat.errors import InputError
from tests.cell.vision.pictures import Ball, Picture, Scene, take
from tests.cell.vision.red_network import COLUMNS, ROWS, network
from tests.cell.vision.vision_scenes import CAMERA, KINDS, PLATES, TABLE, true_calibration


@pytest.fixture(scope="module")
def picture() -> Picture:
    scene = Scene(balls=[Ball("tomato", 0.3, 0.1, 0.03, (190.0, 40.0, 30.0))], plates=PLATES, table=TABLE)
    return take(scene, CAMERA, 5)


def test_geometry_measures_what_a_network_finds(tmp_path: Path, picture: Picture) -> None:
    detector = OnnxDetector(network(tmp_path / "red.onnx"), KINDS, TABLE, size=(ROWS, COLUMNS))
    (found,) = detector.detect(picture, true_calibration())
    assert found.kind == "tomato"
    assert found.position == pytest.approx((0.3, 0.1, 0.03), abs=5e-4)
    assert found.diameter == pytest.approx(0.06, rel=0.01)
    assert found.confidence == pytest.approx(0.9, abs=0.05)


def test_a_number_over_the_kinds_is_of_no_known_kind(tmp_path: Path, picture: Picture) -> None:
    detector = OnnxDetector(network(tmp_path / "red.onnx", last=(0.9, 7.0)), KINDS, TABLE, size=(ROWS, COLUMNS))
    (found,) = detector.detect(picture, true_calibration())
    assert found.kind is None


def test_a_file_that_is_no_network_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        OnnxDetector(tmp_path / "none.onnx", KINDS, TABLE)
    broken = tmp_path / "broken.onnx"
    broken.write_bytes(b"no network")
    with pytest.raises(InputError, match="is not a network"):
        OnnxDetector(broken, KINDS, TABLE)


def test_a_network_of_other_shapes_is_told(tmp_path: Path, picture: Picture) -> None:
    without_kind = OnnxDetector(network(tmp_path / "five.onnx", last=(0.9,)), KINDS, TABLE, size=(ROWS, COLUMNS))
    with pytest.raises(InputError, match=r"an output of the shape \(1, 1, 5\); export it with boxes"):
        without_kind.detect(picture, true_calibration())
    smaller = OnnxDetector(network(tmp_path / "six.onnx"), KINDS, TABLE, size=(320, 320))
    with pytest.raises(InputError, match=r"fails on its input \(1, 3, 320, 320\); give the size"):
        smaller.detect(picture, true_calibration())
