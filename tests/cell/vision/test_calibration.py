from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from layflat.cell.vision import load_calibration
from layflat.errors import CameraError
from tests.cell.vision.vision_scenes import CAMERA, true_calibration

PLACES = np.array([[x, y, z] for x in (0.05, 0.4, 0.78) for y in (-0.25, 0.0, 0.28) for z in (0.0, 0.05)])


def test_pixels_are_those_of_an_independent_lens() -> None:
    assert true_calibration().to_pixels(PLACES) == pytest.approx(CAMERA.project(PLACES), abs=1e-6)


def test_table_and_pixels_are_inverse() -> None:
    calibration = true_calibration()
    pixels = CAMERA.project(PLACES)
    for px, place in zip(pixels, PLACES, strict=True):
        assert calibration.to_table(px, place[2]) == pytest.approx(place[:2], abs=1e-7)
    assert calibration.position == pytest.approx(CAMERA.position)


def test_shapes_are_kept() -> None:
    calibration = true_calibration()
    assert calibration.to_table(np.full((3, 4, 2), 400.0)).shape == (3, 4, 2)
    assert calibration.to_pixels(np.zeros((5, 2, 3))).shape == (5, 2, 2)


def test_resolution() -> None:
    assert true_calibration().pixels_per_metre() == pytest.approx(1500.0, rel=0.02)
    assert true_calibration().pixels_per_metre(0.1) > 1.1 * 1500.0 * 0.98


def test_a_calibration_is_saved_and_read(tmp_path: Path) -> None:
    calibration = true_calibration()
    path = calibration.save(tmp_path / "camera.toml")
    assert load_calibration(path) == calibration
    assert "translation_m" in path.read_text()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("picture_px", "picture", "unknown key; did you mean .picture_px."),
        ("translation_m = [", "translation_m = [nan, ", "translation_m"),
        ("rotation = [", "rotation = 7\nother = [", "rotation"),
        ("=", ":", "is not TOML"),
    ],
)
def test_a_broken_file_is_told(tmp_path: Path, old: str, new: str, told: str) -> None:
    path = true_calibration().save(tmp_path / "camera.toml")
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(CameraError, match=told):
        load_calibration(path)


def test_what_is_no_rotation_is_told(tmp_path: Path) -> None:
    path = tmp_path / "camera.toml"
    true_calibration().model_copy(update={"rotation": ((1, 0, 0), (0, 1, 0), (0, 0, -1))}).save(path)
    with pytest.raises(CameraError, match="rotation: is not a rotation"):
        load_calibration(path)


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match="can't be read"):
        load_calibration(tmp_path / "none.toml")
