from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.kinds import make_detector
from layflat.cell.perception import base_markers, board_poses, calibrate_scene, classify_fruit
from layflat.cell.plan.order import Fruit
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.scene.furniture import camera_optics
from layflat.cell.vision import SURE_CONFIDENCE, Calibration, check_picture, self_check
from layflat.errors import CameraError, PictureError
from tests.cell.cell_pictures import Picture, false_picks, nearest, picture_of, with_camera, with_unknown

vision: Any = cv2


@pytest.fixture(scope="module")
def cell(packing: Cell) -> Cell:
    return with_unknown(packing, "plum")


@pytest.fixture(scope="module")
def scene(cell: Cell) -> Scene:
    return Scene(cell, 2)


@pytest.fixture(scope="module")
def told() -> list[float]:
    return []


@pytest.fixture(scope="module")
def camera(scene: Scene, opengl: None) -> Iterator[SimulatedCamera]:
    with SimulatedCamera(scene) as made:
        yield made


@pytest.fixture(scope="module")
def calibration(scene: Scene, camera: SimulatedCamera, told: list[float]) -> Calibration:
    return calibrate_scene(scene, camera, told.append)


@pytest.fixture(scope="module")
def picture(camera: SimulatedCamera, calibration: Calibration) -> Picture:
    return camera.picture()


def test_the_camera_is_calibrated_from_its_pictures(cell: Cell, calibration: Calibration, told: list[float]) -> None:
    """Points of the table are told within a third of a pixel of where the scene's lens puts them."""
    optics = camera_optics(cell.camera)
    grid = np.stack(np.meshgrid(np.linspace(-0.1, 0.7, 5), np.linspace(0.06, 0.68, 4), [0.0, 0.04]), axis=-1)
    points = grid.reshape(-1, 3)
    ahead = (points - cell.camera.position) * [1.0, -1.0, -1.0]  # it looks straight down
    pixels = vision.projectPoints(ahead, np.zeros(3), np.zeros(3), optics.matrix, optics.distortion)[0].reshape(-1, 2)
    for point, pixel in zip(points, pixels, strict=True):
        assert calibration.to_table(pixel, point[2]) == pytest.approx(point[:2], abs=2.5e-4)
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_the_board_is_held_in_all_parts_of_the_picture_and_tilted(cell: Cell) -> None:
    spots = np.array([position for position, _ in board_poses(cell)])
    assert np.ptp(spots[:, 0]) > 0.3
    assert np.ptp(spots[:, 1]) > 0.2
    assert (spots[:, 2] > 0.1).all()


def test_the_scene_is_as_it_was_after_calibration(scene: Scene, calibration: Calibration) -> None:
    assert not scene.board_held


def test_what_lies_in_the_tray_is_seen(scene: Scene, cell: Cell, calibration: Calibration, picture: Picture) -> None:
    found = make_detector(cell).detect(picture, calibration)
    truth = scene.truth().fruits
    kinds = {fruit.kind for fruit in truth.values()}
    assert kinds == {"tomato", "apple", "mushroom", "plum"}
    assert not false_picks(found, truth)
    for fruit in truth.values():
        one = nearest(found, fruit)
        assert one.confidence >= SURE_CONFIDENCE
        assert one.position[:2] == pytest.approx(fruit.position[:2], abs=1e-3)
        assert one.diameter == pytest.approx(fruit.diameter, rel=0.02)
        graded = classify_fruit(cell, one)
        if fruit.kind == "plum":
            assert one.kind is None
            assert graded.ungraded_reason
        else:
            assert one.kind == fruit.kind
            assert graded.ungraded_reason or graded.grade == fruit.grade
        assert cell.place_at(*one.position[:2]) is None
    wide = [nearest(found, fruit).diameter / fruit.diameter for fruit in truth.values()]
    assert np.mean(wide) == pytest.approx(1.0, abs=3e-3)


def test_what_lies_in_packs_is_told_by_place(cell: Cell, calibration: Calibration) -> None:
    scene = Scene(cell, 8)
    small = [fruit for fruit in scene.fruits if fruit.kind in {"mushroom", "tomato"}]
    for number, laid in enumerate(small):
        name = ("mushrooms", "tomatoes")[number % 2]
        start = int(scene.model.joint(laid.name).qposadr[0])
        spot = cell.container[name].places[number // 2]
        height = cell.container[name].layout.wall + laid.height_below + 1e-3
        scene.data.qpos[start : start + 7] = [*spot, height, 1.0, 0.0, 0.0, 0.0]
    scene.step(300)
    truth = {name: fruit for name, fruit in scene.truth().fruits.items() if fruit.place is not None}
    assert len(truth) >= 4
    found = make_detector(cell).detect(picture_of(scene), calibration)
    for fruit in truth.values():
        one = nearest(found, fruit)
        assert (one.kind, cell.place_at(*one.position[:2])) == (fruit.kind, fruit.place)
        assert one.confidence >= SURE_CONFIDENCE
        assert one.position[:2] == pytest.approx(fruit.position[:2], abs=2e-3)
    assert sum(cell.place_at(*one.position[:2]) is not None for one in found) == len(truth)


def test_a_blurred_picture_is_refused(cell: Cell, calibration: Calibration, picture: Picture) -> None:
    check_picture(picture)
    for spoilt in (vision.GaussianBlur(picture, (0, 0), 3.0), vision.blur(picture, (15, 1))):
        with pytest.raises(PictureError, match="blurred"):
            make_detector(cell).detect(spoilt, calibration)


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize(
    ("change", "told"), [({"exposure": 0.02}, "is black"), ({"exposure": 6.0}, "is white"), ({"blur": 3.0}, "blurred")]
)
def test_a_camera_that_is_set_wrongly_is_refused(cell: Cell, change: dict[str, Any], told: str) -> None:
    with pytest.raises(PictureError, match=told):
        check_picture(picture_of(Scene(with_camera(cell, **change), 2)))


@pytest.mark.usefixtures("opengl")
def test_lights_out_is_refused(cell: Cell) -> None:
    dark = cell.ambient.model_copy(update=dict.fromkeys(("mean", "min", "max", "std"), 0.0))
    with pytest.raises(PictureError, match="is black"):
        check_picture(picture_of(Scene(cell.model_copy(update={"ambient": dark, "light": {}}), 2)))


def test_a_camera_that_stayed_is_accepted(cell: Cell, calibration: Calibration, picture: Picture) -> None:
    assert self_check(picture, calibration, base_markers(cell)) < 7e-4


@pytest.mark.parametrize(
    "moved",
    [
        {"position": (0.31, 0.37, 1.5), "looks_at": (0.31, 0.37, 0.0)},
        {"position": (0.3, 0.37, 1.51)},
        {"looks_at": (0.3, 0.37 + 1.5 * np.tan(np.deg2rad(0.5)), 0.0)},
        {"rotation": np.deg2rad(0.5)},
    ],
)
def test_a_camera_that_was_moved_is_refused(cell: Cell, calibration: Calibration, moved: dict[str, Any]) -> None:
    with pytest.raises(CameraError, match="the camera was moved"):
        self_check(picture_of(Scene(with_camera(cell, **moved), 2)), calibration, base_markers(cell))


@pytest.mark.parametrize("colour", [(0, 0, 0), (205, 150, 120), (235, 235, 235)])
def test_behind_a_hand_or_a_cap_nothing_is_made_up(
    scene: Scene, cell: Cell, calibration: Calibration, picture: Picture, colour: tuple[int, int, int]
) -> None:
    """A cap over the right of the lens, a finger, a glove: what is left of the tray is seen as before."""
    covered = picture.copy()
    vision.circle(covered, (1150, 620), 220, colour, -1, vision.LINE_AA)
    vision.line(covered, (1150, 620), (1280, 0), colour, 120, vision.LINE_AA)
    found = make_detector(cell).detect(covered, calibration)
    truth = scene.truth().fruits
    assert not false_picks(found, truth)
    for fruit in truth.values():
        pixel = calibration.to_pixels(fruit.position)
        away = np.hypot(*(pixel - [1150, 620])) - 220
        if away > 80:
            assert nearest(found, fruit).position[:2] == pytest.approx(fruit.position[:2], abs=1e-3)
        elif away < -60:
            gap = nearest(found, fruit).position[:2] - fruit.position[:2]
            assert np.hypot(*gap) > fruit.diameter / 4


def test_a_covered_tray_shows_no_fruit(cell: Cell, calibration: Calibration, picture: Picture) -> None:
    """A cloth over half of the picture."""
    covered = picture.copy()
    covered[:, 640:] = 0
    assert not [one for one in make_detector(cell).detect(covered, calibration) if one.position[0] > 0.3]


def test_a_picture_without_table_is_refused(cell: Cell, calibration: Calibration, picture: Picture) -> None:
    covered = picture.copy()
    covered[:, :] = (205, 150, 120)
    covered[::40] = (40, 20, 10)
    covered[:, ::40] = (40, 20, 10)
    with pytest.raises(PictureError, match="shows no table"):
        make_detector(cell).detect(covered, calibration)


def test_graded_fruit_is_what_plans_take(cell: Cell, calibration: Calibration, picture: Picture) -> None:
    graded = [classify_fruit(cell, one) for one in make_detector(cell).detect(picture, calibration)]
    assert sum(isinstance(one, Fruit) for one in graded) >= 8
