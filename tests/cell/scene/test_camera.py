from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.bridge.view.picture import GL_LIBRARIES, gl_context
from layflat.cell import Cell
from layflat.cell.extras import CharucoBoard, make_charuco_board
from layflat.cell.file.imaging import Board
from layflat.cell.geometry import look_at_orientation, rectangle_corners
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera, expose
from layflat.cell.scene.furniture import Optics, camera_optics
from layflat.errors import LayflatError

Array = NDArray[np.float64]


def matrix(quaternion: tuple[float, float, float, float]) -> Array:
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def seen_at(cell: Cell, points: Array) -> Array:
    """Where the camera's own numbers put points of the cell, px."""
    optics = camera_optics(cell.camera)
    before = (points - np.array(cell.camera.position)) @ matrix(optics.orientation) * [1.0, -1.0, -1.0]
    pixels = cv2.projectPoints(before, np.zeros(3), np.zeros(3), optics.matrix, optics.distortion)[0]
    return np.asarray(pixels, np.float64).reshape(-1, 2)


def corners(board: Board, picture: NDArray[np.uint8]) -> tuple[Array, Array]:
    """Corners that OpenCV finds: in the board's plane, m, and in the picture, px."""
    pattern = make_charuco_board(CharucoBoard(**board.model_dump()))
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    found, numbers, _, _ = cv2.aruco.CharucoDetector(pattern).detectBoard(grey)
    if numbers is None:
        return np.zeros((0, 3)), np.zeros((0, 2))
    x, y, _ = np.asarray(pattern.getChessboardCorners())[numbers.ravel()].T
    width, height = board.size
    return np.stack([x - width / 2, height / 2 - y, 0 * x], axis=1), np.asarray(found, np.float64).reshape(-1, 2)


@pytest.fixture(scope="module")
def scene(packing: Cell) -> Scene:
    return Scene(packing, 2)


@pytest.fixture(scope="module")
def camera(scene: Scene, opengl: None) -> Iterator[SimulatedCamera]:
    with SimulatedCamera(scene) as made:
        yield made


def test_the_base_markers_are_seen_where_they_lie(packing: Cell, camera: SimulatedCamera) -> None:
    """Their edges, half way from black to white, along the middle half of each side: corners are rounded by blur."""
    grey = cv2.cvtColor(camera.picture(), cv2.COLOR_RGB2GRAY).astype(np.float32)
    base = packing.base_markers
    across = np.linspace(-3.0, 3.0, 121)
    for marker in base.marker.values():
        outline = rectangle_corners(marker.centre, marker.rotation, (marker.side, marker.side))
        sides = seen_at(packing, np.column_stack([outline, np.full(4, base.thickness)]))
        for one, other in zip(sides, np.roll(sides, -1, axis=0), strict=True):
            outwards = (one + other) / 2 - sides.mean(axis=0)
            outwards /= np.linalg.norm(outwards)
            on = one + np.linspace(0.25, 0.75, 20)[:, None] * (other - one)
            at = (on[:, None] + across[:, None] * outwards).astype(np.float32)
            levels = cv2.remap(grey, at[..., 0], at[..., 1], cv2.INTER_LINEAR)
            half = (levels.max(axis=1) + levels.min(axis=1))[:, None] / 2
            assert abs(across[(levels > half).argmax(axis=1)].mean()) < 0.25


def test_a_held_board_is_seen_where_it_is_held_and_gone_when_put_away(
    packing: Cell, scene: Scene, camera: SimulatedCamera
) -> None:
    turn = (float(np.cos(0.15)), float(np.sin(0.15)), 0.0, 0.0)
    at = np.array([0.32, 0.40, 0.25])
    scene.hold_board(at, np.array(turn))
    flat, pixels = corners(packing.board, camera.picture())
    scene.board_held = False
    assert len(flat) == (packing.board.columns - 1) * (packing.board.rows - 1)
    error = seen_at(packing, flat @ matrix(turn).T + at) - pixels
    assert np.sqrt((error**2).sum(axis=1).mean()) < 0.25
    assert len(corners(packing.board, camera.picture())[0]) == 0


def test_a_millimetre_on_the_table_is_a_pixel_at_least_and_all_is_in_sight(packing: Cell) -> None:

    metre = np.array([[0.3, 0.37, 0.0], [0.301, 0.37, 0.0]])
    first, second = seen_at(packing, metre)
    assert np.linalg.norm(second - first) > 1.0
    for name, outline in packing.outlines.items():
        if "column" not in name:
            pixels = seen_at(packing, np.column_stack([outline, np.zeros(4)]))
            assert (pixels > 0).all()
            assert (pixels < [packing.camera.width, packing.camera.height]).all()


def test_pictures_differ_by_noise_alone_and_repeat_by_seed(
    packing: Cell, scene: Scene, camera: SimulatedCamera
) -> None:
    with SimulatedCamera(scene) as other:
        one, two = other.picture(), other.picture()
    with SimulatedCamera(Scene(packing, 2)) as again:
        assert np.array_equal(again.picture(), one)
        assert np.array_equal(again.picture(), two)
    difference = one.astype(float) - two.astype(float)
    assert one.shape == (packing.camera.height, packing.camera.width, 3)
    assert 1.0 < difference.std() < 6.0
    assert np.abs(difference.mean()) < 0.05


def test_fruit_stands_out_in_its_colour(scene: Scene, packing: Cell, camera: SimulatedCamera) -> None:
    picture = camera.picture()
    for fruit in scene.truth().fruits.values():
        u, v = seen_at(packing, fruit.position[None] + [[0.3 * fruit.diameter, 0.0, 0.25 * fruit.height]])[0]
        patch = picture[int(v) - 2 : int(v) + 3, int(u) - 2 : int(u) + 3].reshape(-1, 3).mean(axis=0)
        drawn = np.array(next(one.rgb for one in scene.fruits if one.name == fruit.name))
        likeness = patch @ drawn / np.linalg.norm(patch) / np.linalg.norm(drawn)
        assert likeness > 0.97, fruit.name


def test_the_overview_shows_the_whole_cell(packing: Cell, camera: SimulatedCamera) -> None:
    picture = camera.picture("overview")
    assert picture.shape == (packing.overview.height, packing.overview.width, 3)
    assert picture.std() > 20


def test_without_exposure_the_picture_is_black(packing: Cell) -> None:
    dark = packing.camera.model_copy(update={"exposure": 0.0})
    white = np.full((40, 60, 3), 255, np.uint8)
    assert expose(white, dark, np.random.default_rng(0)).mean() < 2.0


def test_noise_is_as_described(packing: Cell) -> None:
    grey = np.full((300, 300, 3), 120, np.uint8)
    seen = expose(grey, packing.camera, np.random.default_rng(0)).astype(float)
    expected = np.sqrt(packing.camera.read_noise**2 + packing.camera.shot_noise * 120 + 1 / 12)
    assert seen.std() == pytest.approx(expected, rel=0.03)
    assert seen.mean() == pytest.approx(120, abs=0.05)


@pytest.mark.parametrize("rotation", [0.0, 0.7, -2.0])
def test_a_camera_looks_where_it_is_pointed(rotation: float) -> None:
    for position, target in (((0.3, 0.2, 1.5), (0.3, 0.2, 0.0)), ((1.2, -0.7, 1.0), (0.2, 0.2, 0.1))):
        R = matrix(look_at_orientation(position, target, rotation))
        along = np.subtract(target, position)
        assert -R[:, 2] == pytest.approx(along / np.linalg.norm(along))
        assert np.linalg.det(R) == pytest.approx(1.0)
        if rotation == 0.0:
            assert R[:, 1] @ [0, 1, 0] > 0.5 or R[2, 1] > 0.5


def test_a_lens_without_distortion_changes_nothing_but_the_frame(packing: Cell) -> None:
    straight = packing.camera.distortion.model_copy(update=dict.fromkeys(("k1", "k2", "p1", "p2", "k3"), 0.0))
    plain = Optics(packing.camera.model_copy(update={"distortion": straight, "principal_offset": (0.0, 0.0)}))
    width, height = plain.wide
    ideal = np.random.default_rng(0).integers(0, 255, (height, width, 3), dtype=np.uint8)
    left, top = (width - packing.camera.width) // 2, (height - packing.camera.height) // 2
    cut = ideal[top : top + packing.camera.height, left : left + packing.camera.width]
    assert np.abs(plain.bend(ideal).astype(int) - cut).max() <= 1


def test_a_missing_library_is_named_with_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    for way in GL_LIBRARIES:
        monkeypatch.setitem(GL_LIBRARIES, way, "libNoSuchThing.so.1")
    with pytest.raises(LayflatError, match="apt-get install libegl1 libgl1-mesa-dri"):
        gl_context(64, 64)


def test_a_way_to_draw_that_fails_is_told_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "osmosis")
    with pytest.raises(LayflatError, match="osmosis") as caught:
        gl_context(64, 64)
    assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("opengl")
def test_an_overview_leaves_the_cameras_pictures_as_fine_as_they_were(packing: Cell) -> None:
    scene = Scene(packing, 3)
    with SimulatedCamera(scene) as alone, SimulatedCamera(scene) as both:
        before = both.picture("overview")
        assert np.array_equal(both.picture(), alone.picture())
        assert np.array_equal(both.picture("overview"), before)
