"""Observations of the cell: images and vision, or the scene's truth with noise where no image can be rendered.

The camera is calibrated as one on a rig is: a board held before it, then the markers on the table. A detected fruit
gets the grade by which it is packed, or the reason why it has none. Its skin is identified by its chromaticity, r and g
of r + g + b = 1, which is independent of brightness. A perception with a camera does not know the scene's truth.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos, pi, sin
from typing import Protocol

import numpy as np

from layflat.arrays import Array, Picture
from layflat.cell.file.model import Cell
from layflat.cell.file.produce import Produce, Skin
from layflat.cell.geometry import quaternion_product, rotate_vector
from layflat.cell.kinds import make_detector
from layflat.cell.plan.order import Fruit
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.scene.furniture import camera_optics
from layflat.cell.vision import BaseMarkers, Calibration, CharucoBoard, Detection, Marker, calibrate, self_check

__all__ = ["Observation", "base_markers", "board_poses", "calibrate_scene", "classify_fruit"]

# Positions of the board, of -1 to 1 across the picture: in its middle, then around it.
BOARD_SPOTS = ((0, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0))
BOARD_TILT = 0.5  # of the board from facing the camera, rad, to another side in each view
BOARD_FRACTION = 0.42  # of the picture's width or height that the board fills
DIAMETER_ERROR = 0.015  # greatest relative error of vision: the worst of 1800 fruit, see docs/cell-vision.md
TINT_ERROR = 0.01  # of a chromaticity, by lights of different tint
AMBIGUITY_RATIO = 0.6  # of two skins' distances, above which the skin is ambiguous
UNKNOWN_KIND = "unknown"  # of an unknown object, which is an obstacle all the same


def calibrate_scene(
    scene: Scene, camera: SimulatedCamera, progress: Callable[[float], object] = lambda _: None
) -> Calibration:
    """Calibrate with the cell's board in nine poses before the camera, then with the markers on the table.

    The arm of the scene has to be out of the camera's view. The board is removed after its pictures.

    Args:
        scene: scene whose board and markers are used.
        camera: camera of the scene.
        progress: called with the completed fraction.

    Raises:
        PictureError: a picture is dark or blurred.
        CameraError: as `calibrate`, such as for a board or markers that are not detected.
    """
    poses, pictures = board_poses(scene.cell), []
    for number, (position, orientation) in enumerate(poses, start=1):
        scene.hold_board(position, orientation)
        pictures.append(camera.picture())
        progress(number / (len(poses) + 2))
    scene.board_held = False
    board = CharucoBoard(**scene.cell.board.model_dump())
    calibration = calibrate(pictures, board, camera.picture(), base_markers(scene.cell))
    progress(1.0)
    return calibration


def base_markers(cell: Cell) -> BaseMarkers:
    """Return the markers on a cell's table."""
    base = cell.base_markers
    lying = (Marker(m.number, *m.centre, m.side, m.rotation, base.thickness) for m in base.marker.values())
    return BaseMarkers(tuple(lying), base.dictionary)


def board_poses(cell: Cell) -> list[tuple[Array, Array]]:
    """Return tilted poses of the board in all parts of the picture: middle (3,), m, and quaternion, w first."""
    camera, facing = cell.camera, np.array(camera_optics(cell.camera).orientation)
    wide, high = cell.board.size
    away = camera.focal_pixels * max(wide / (BOARD_FRACTION * camera.width), high / (BOARD_FRACTION * camera.height))
    # At the picture's edges the whole board is still in view.
    reach = 0.5 * (0.96 - BOARD_FRACTION) * np.array([camera.width, camera.height]) / camera.focal_pixels
    poses = []
    for number, (right, up) in enumerate(BOARD_SPOTS):
        offset = away * np.array([right * reach[0], up * reach[1], -1.0])
        direction = 2.0 * pi * number * 3 / len(BOARD_SPOTS) + 0.4 * number
        tilted = np.array(
            [cos(BOARD_TILT / 2), sin(BOARD_TILT / 2) * cos(direction), sin(BOARD_TILT / 2) * sin(direction), 0.0]
        )
        poses.append((np.array(camera.position) + rotate_vector(facing, offset), quaternion_product(facing, tilted)))
    return poses


@dataclass(frozen=True, eq=False)
class Observation:
    """Image of the table and the detections in it."""

    time: float  # s
    fruits: tuple[Fruit, ...]  # all produce that was detected, also in containers and of unknown kinds
    picture: Picture | None = None  # RGB
    detections: tuple[Detection, ...] = ()  # of vision in the picture


class Perception(Protocol):
    """Observer of the table from above."""

    position: Array  # of the camera, (3,) m

    def observe(self, time: float) -> Observation:
        """Return an observation of the table now, with `time` (s) as its time.

        Raises:
            PictureError: the picture can't be used.
        """
        ...


class CameraPerception:
    """Perception by a calibrated camera, whose pictures `picture` takes, and the cell's detector."""

    def __init__(self, cell: Cell, picture: Callable[[], Picture], calibration: Calibration) -> None:
        self._cell, self._picture, self._calibration = cell, picture, calibration
        self._detector, self._base = make_detector(cell), base_markers(cell)
        self.position = calibration.position

    def check(self) -> float:
        """Return the greatest position error of the markers on the table, m; raise as `self_check`."""
        return self_check(self._picture(), self._calibration, self._base)

    def observe(self, time: float) -> Observation:
        """Return the detections in a new image."""
        picture = self._picture()
        detections = self._detector.detect(picture, self._calibration)
        fruits = tuple(classify_fruit(self._cell, detection) for detection in detections)
        return Observation(time, fruits, picture, tuple(detections))


class ScenePerception:
    """Perception without images: the scene's truth with the noise of a camera's detections."""

    POSITION_DEVIATION, DIAMETER_DEVIATION = 0.3e-3, 0.005  # standard deviations: of each coordinate, m; relative

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._rng = np.random.default_rng([scene.seed, 0xE7E5])
        self.position = np.array(scene.cell.camera.position)

    def observe(self, time: float) -> Observation:
        """Return all fruit in the cell and the camera's view that is not held, with noise."""
        fruits = []
        for fruit in self._scene.truth().fruits.values():
            x, y = fruit.position[:2] + self._rng.normal(0.0, self.POSITION_DEVIATION, 2)
            diameter = fruit.diameter * (1.0 + self._rng.normal(0.0, self.DIAMETER_DEVIATION))
            if fruit.here and not fruit.gripped and self._scene.cell.camera.sees((x, y)):
                fruits.append(Fruit(float(x), float(y), float(diameter), fruit.kind, fruit.grade or ""))
        return Observation(time, tuple(fruits))


def classify_fruit(cell: Cell, detection: Detection) -> Fruit:
    """Return a detected fruit as plans use it, with its grade or the reason why it has none."""
    grade, reason = _grade_or_reason(cell, detection)
    x, y, _ = detection.position
    return Fruit(x, y, detection.diameter, detection.kind or UNKNOWN_KIND, grade, detection.confidence, reason)


def _grade_or_reason(cell: Cell, detection: Detection) -> tuple[str, str]:
    """Return the grade, and the reason why there is none as a clause; one of them is empty."""
    if detection.kind is None or detection.kind not in cell.produce:
        return "", "is of no kind that is known here"
    produce, diameter = cell.produce[detection.kind], detection.diameter
    skin, other = _nearest_skins(produce.colour, detection.colour)
    if other:
        return "", f"could be {skin} or {other}"
    grades = _possible_grades(produce, diameter, skin)
    if len(grades) > 1:
        names = " or ".join(grade or "none" for grade in grades)
        return "", f"is too near to a limit: {1e3 * diameter:.1f} mm may be of grade {names}"
    return (grades[0], "") if grades[0] else ("", f"is of no grade: {skin}, {1e3 * diameter:.0f} mm")


def _nearest_skins(skins: Mapping[str, Skin], colour: tuple[float, float, float]) -> tuple[str, str]:
    """Return the name of the nearest skin, and of the next if the distances' ratio is over `AMBIGUITY_RATIO`, else "".

    Distances are those of chromaticities, in standard deviations of each skin.
    """
    measured = _chromaticity(colour)
    deviations = {name: float(np.hypot(0.5 * skin.std / sum(skin.rgb), TINT_ERROR)) for name, skin in skins.items()}
    distances = {
        name: float(np.linalg.norm(measured - _chromaticity(skin.rgb))) / deviations[name]
        for name, skin in skins.items()
    }
    nearest, *others = sorted(distances, key=lambda name: distances[name])
    return nearest, others[0] if others and distances[nearest] > AMBIGUITY_RATIO * distances[others[0]] else ""


def _chromaticity(colour: tuple[float, float, float]) -> Array:
    """Return r and g of a colour, scaled so that r + g + b = 1."""
    return np.array(colour[:2]) / max(sum(colour), 1e-6)


def _possible_grades(produce: Produce, diameter: float, colour: str) -> list[str | None]:
    """Return the grades that a fruit may have within `DIAMETER_ERROR` of its diameter, by size; None: of no grade."""
    low, high = diameter * (1.0 - DIAMETER_ERROR), diameter * (1.0 + DIAMETER_ERROR)
    limits = [limit for grade in produce.grade.values() for limit in (grade.min, grade.max) if low < limit <= high]
    return list(dict.fromkeys(produce.grade_of(possible, colour) for possible in (low, *sorted(limits))))
