"""What the cell observes: images and vision, or where no image can be rendered, the scene's own truth with noise."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from layflat.cell.file.model import Cell
from layflat.cell.perception.calibrating import base_of
from layflat.cell.perception.grading import fruit_of
from layflat.cell.perception.kinds import detector_of
from layflat.cell.plan.fruit import Fruit
from layflat.cell.scene import Scene
from layflat.cell.vision import Calibration, Detection, self_check

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Observation:
    """One image of the table and what was detected in it."""

    time: float  # s
    fruits: tuple[Fruit, ...]  # all produce that was detected, also in containers and of unknown kinds
    picture: Picture | None = None  # (H, W, 3) RGB
    detections: tuple[Detection, ...] = ()  # of vision in the picture


class Perception(Protocol):
    """What observes the table from above."""

    position: Array
    """Of the camera, (3,) m."""

    def observe(self, time: float) -> Observation:
        """Return what lies there now; raise PictureError if the picture can't be used."""
        ...


class CameraPerception:
    """A calibrated camera, whose pictures `picture` takes, and a detector as the cell says, by colour or a network."""

    def __init__(self, cell: Cell, picture: Callable[[], Picture], calibration: Calibration) -> None:
        self._cell, self._picture, self._calibration = cell, picture, calibration
        self._detector, self._base = detector_of(cell), base_of(cell)
        self.position = calibration.position

    def check(self) -> float:
        """Return how far the markers on the table are from where the calibration says, m.

        Raises:
            PictureError: the picture can't be used.
            CameraError: they are off: the camera was moved, or is miscalibrated.
        """
        return self_check(self._picture(), self._calibration, self._base)

    def observe(self, time: float) -> Observation:
        """Return what is detected in a new image."""
        picture = self._picture()
        found = self._detector.find(picture, self._calibration)
        return Observation(time, tuple(fruit_of(self._cell, one) for one in found), picture, tuple(found))


class ScenePerception:
    """In place of a camera where no image can be rendered: the scene's truth, spread as a camera's detections."""

    SPREAD, SIZE = 0.3e-3, 0.005  # standard deviation of each coordinate, m, and of diameters, share

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._rng = np.random.default_rng([scene.seed, 0xE7E5])
        self.position = np.array(scene.cell.camera.position)

    def observe(self, time: float) -> Observation:
        """Return all fruit that is not held."""
        found = []
        for fruit in self._scene.truth().fruits.values():
            x, y = fruit.position[:2] + self._rng.normal(0.0, self.SPREAD, 2)
            diameter = fruit.diameter * (1.0 + self._rng.normal(0.0, self.SIZE))
            if not fruit.held:
                found.append(Fruit(float(x), float(y), float(diameter), fruit.kind, fruit.grade or ""))
        return Observation(time, tuple(found))
