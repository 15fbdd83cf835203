from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from layflat.cell.extras import make_charuco_board
from layflat.cell.vision import (
    BaseBoard,
    BaseMarkers,
    Calibration,
    CharucoBoard,
    Checkerboard,
    Marker,
    calibrate,
    self_check,
)
from layflat.errors import CameraError, PictureError
from tests.cell.vision.pictures import Flat, Picture, Plate, Scene, take
from tests.cell.vision.vision_scenes import (
    BOARD,
    CAMERA,
    MARKERS,
    PLATES,
    TABLE,
    board_plate,
    board_scenes,
    true_calibration,
)

EMPTY = Scene(plates=PLATES, table=TABLE)


@pytest.fixture(scope="module")
def views() -> list[Picture]:
    return [take(scene, CAMERA, seed) for seed, scene in enumerate(board_scenes(8))]


@pytest.fixture(scope="module")
def base() -> Picture:
    return take(EMPTY, CAMERA, 99)


@pytest.fixture(scope="module")
def calibration(views: list[Picture], base: Picture) -> Calibration:
    return calibrate(views, BOARD, base, MARKERS)


def test_the_camera_is_found_from_pictures(calibration: Calibration) -> None:
    assert calibration.camera_matrix_px[0][0] == pytest.approx(CAMERA.focal[0], rel=2e-3)
    assert calibration.position == pytest.approx(CAMERA.position, abs=4e-3)
    assert calibration.lens_error_px < 0.3
    assert calibration.pose_error_px < 0.4


def test_same_pictures_same_calibration_to_the_last_bit(
    views: list[Picture], base: Picture, calibration: Calibration
) -> None:
    for _ in range(3):
        assert calibrate(views, BOARD, base, MARKERS) == calibration


def test_pixels_are_places_to_half_a_millimetre(calibration: Calibration) -> None:
    for height in (0.0, 0.05):
        places = np.array([[x, y, height] for x in (0.1, 0.4, 0.74) for y in (-0.2, 0.0, 0.25)])
        found = calibration.to_table(CAMERA.project(places), height)
        assert np.linalg.norm(found - places[:, :2], axis=1).max() < 5e-4


def test_too_few_views(views: list[Picture], base: Picture) -> None:
    with pytest.raises(CameraError, match="detected in 3 of 3 pictures; show it in at least 6"):
        calibrate(views[:3], BOARD, base, MARKERS)


def test_a_board_that_is_not_seen(views: list[Picture], base: Picture) -> None:
    with pytest.raises(CameraError, match="the board is detected in 0 of 2"):
        calibrate([base, base], BOARD, base, MARKERS)


def test_views_too_much_alike(views: list[Picture], base: Picture) -> None:
    flat = Scene(plates=(board_plate(BOARD, (0.42, 0.03, 0.0), CAMERA.tilt),), table=TABLE)
    view = take(flat, CAMERA, 1)
    with pytest.raises(CameraError, match="the board is tilted by 0 degrees at most"):
        calibrate([view] * 6, BOARD, base, MARKERS)


def test_blurred_and_black_views_are_named(views: list[Picture], base: Picture) -> None:
    with pytest.raises(PictureError, match="board picture 2: is black"):
        calibrate([views[0], np.zeros_like(base)], BOARD, base, MARKERS)
    with pytest.raises(PictureError, match=r"base picture: .* blurred"):
        calibrate(views, BOARD, take(EMPTY, CAMERA, 1, blur=5.0), MARKERS)


def test_no_base_marker(views: list[Picture], base: Picture) -> None:
    with pytest.raises(CameraError, match=r"no base marker \(0, 1, 2, 3\) is in the image"):
        calibrate(views, BOARD, views[0], MARKERS)


def test_base_markers_told_wrongly(views: list[Picture], base: Picture) -> None:
    first, *others = MARKERS.markers
    with pytest.raises(CameraError, match=r"base markers are off by .* px in the best-fitting pose"):
        calibrate(views, BOARD, base, BaseMarkers((replace(first, x=first.x + 0.02), *others)))


def test_a_camera_that_stayed_is_accepted() -> None:
    scene = replace(EMPTY, ambient=0.3, tint=(1.05, 1.0, 0.95))
    assert self_check(take(scene, CAMERA, 7), true_calibration(), MARKERS) < 5e-4


@pytest.mark.parametrize("moved", [{"position": (0.425, 0.03, 1.0)}, {"tilt": (0.036, -0.02, 0.01)}])
def test_a_camera_that_was_moved_is_refused(moved: dict[str, Any]) -> None:
    picture = take(EMPTY, replace(CAMERA, **moved), 7)
    with pytest.raises(CameraError, match=r"base markers are off by [4-9]\.\d mm .* calibrate it anew"):
        self_check(picture, true_calibration(), MARKERS)


def test_a_lens_that_was_turned_is_refused() -> None:
    zoomed = replace(CAMERA, focal=(1515.0, 1517.0))
    with pytest.raises(CameraError, match="self-check"):
        self_check(take(EMPTY, zoomed, 7), true_calibration(), MARKERS)


def test_covered_markers_are_told() -> None:
    with pytest.raises(CameraError, match="no base marker"):
        self_check(take(board_scenes(1)[0], CAMERA, 7), true_calibration(), MARKERS)


def test_one_marker_gives_a_pose(views: list[Picture], calibration: Calibration, base: Picture) -> None:
    alone = calibrate(views, BOARD, base, BaseMarkers(MARKERS.markers[:1]))
    near = CAMERA.project(np.array([MARKERS.markers[0].x + 0.05, MARKERS.markers[0].y, 0.0]))
    assert alone.to_table(near) == pytest.approx([MARKERS.markers[0].x + 0.05, MARKERS.markers[0].y], abs=1e-3)


def test_a_board_can_be_the_base_marker() -> None:
    board = CharucoBoard(5, 3, 0.04, 0.03, first_id=30)
    texture = make_charuco_board(board).generateImage((500, 300))
    c, s = np.cos(0.2), np.sin(0.2)
    right, down = 0.2 * np.array([c, s, 0.0]), 0.12 * np.array([s, -c, 0.0])
    plate = Plate(texture, np.array([0.3, 0.1, 0.0]) - (right + down) / 2, right, down)
    sheet = Flat(0.3, 0.1, 0.23, 0.15, (230.0, 230.0, 230.0), yaw=0.2)
    picture = take(replace(EMPTY, plates=(plate,), flats=(sheet,)), CAMERA, 5)
    assert self_check(picture, true_calibration(), BaseBoard(board, 0.3, 0.1, yaw=0.2)) < 4e-4
    with pytest.raises(CameraError, match=r"off by 5\.\d mm"):
        self_check(picture, true_calibration(), BaseBoard(board, 0.3, 0.105, yaw=0.2))
    with pytest.raises(CameraError, match=r"no base marker \(board of 5 x 3, from number 10\) is in the image"):
        self_check(picture, true_calibration(), BaseBoard(replace(board, first_id=10), 0.3, 0.1))


def test_a_dictionary_with_too_few_markers_is_told() -> None:
    with pytest.raises(CameraError, match="DICT_4X4_50 has only 50 markers, number 51 is needed"):
        make_charuco_board(CharucoBoard(5, 3, 0.04, 0.03, first_id=45))


def test_a_checkerboard_is_seen_where_it_is() -> None:
    squares = np.kron(np.indices((6, 9)).sum(axis=0) % 2, np.ones((60, 60)))
    texture = np.pad((255 * squares).astype(np.uint8), 60, constant_values=255)
    step = 0.03
    plate = Plate(texture, np.array([0.25, 0.15, 0.0]), np.array([11 * step, 0, 0]), np.array([0, -8 * step, 0]))
    picture = take(Scene(plates=(plate,), table=TABLE), CAMERA, 3)
    seen = Checkerboard(9, 6, step).detect(picture[..., 1].copy())
    assert seen is not None
    known, pixels = seen
    first = np.array([0.25 + 2 * step, 0.15 - 2 * step, 0.0])
    true = CAMERA.project(first + known * [1, -1, 1])
    turned = CAMERA.project(first + np.array([7 * step, -4 * step, 0.0]) - known * [1, -1, 1])
    off = min(np.abs(pixels - true).max(), np.abs(pixels - turned).max())
    assert off < 0.3


def test_what_is_nearly_a_marker_or_read_twice_is_left_out() -> None:
    cv2: Any = __import__("cv2")
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    grey = np.full((300, 900), 200, np.uint8)
    drawn = [cv2.aruco.generateImageMarker(words, number, 120) for number in (1, 2, 2)]
    nearly = cv2.aruco.generateImageMarker(words, 3, 120)
    nearly[20:40, 20:40] = 255 - nearly[20:40, 20:40]
    for place, marker in enumerate([*drawn, nearly]):
        grey[90:210, 60 + 210 * place : 180 + 210 * place] = marker
    markers = tuple(Marker(number, 0.1 * number, 0.0, 0.04) for number in (1, 2, 3))
    seen = BaseMarkers(markers).detect(grey)
    assert seen is not None
    assert seen[0] == pytest.approx(markers[0].corners)


def test_markers_need_numbers_of_their_own() -> None:
    with pytest.raises(CameraError, match="each with its own number"):
        BaseMarkers((Marker(1, 0.0, 0.0, 0.05), Marker(1, 0.1, 0.0, 0.05)))


def test_an_unknown_dictionary_is_told() -> None:
    with pytest.raises(CameraError, match="unknown dictionary 'DICT_9X9'"):
        CharucoBoard(9, 7, 0.03, 0.02, "DICT_9X9").detect(np.zeros((100, 100), np.uint8))
