"""What the cell sees: the camera's pictures with vision, or where no picture can be drawn, the scene's own truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from layflat.cell.eyes import base_of, detector_of, fruit_of
from layflat.cell.file.model import Cell
from layflat.cell.plan.fruit import Fruit
from layflat.cell.scene import Scene
from layflat.cell.vision import Calibration, Detection, Detector, self_check

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Sight:
    """One look.

    Attributes:
        time: s.
        fruits: all produce that was seen, also in packs and of unknown kinds.
        picture: (H, W, 3) RGB; None where there is none.
        detections: of vision in the picture.
    """

    time: float
    fruits: tuple[Fruit, ...]
    picture: NDArray[np.uint8] | None = None
    detections: tuple[Detection, ...] = ()


class Eyes(Protocol):
    """What looks at the table from above."""

    position: Array
    """Of the camera, (3,) m."""

    def look(self, time: float) -> Sight:
        """What lies there now.

        Raises:
            PictureError: the picture can't be used.
        """
        ...


class CameraEyes:
    """A calibrated camera and a detector.

    Args:
        cell: whose produce is looked for.
        picture: takes one, (H, W, 3) RGB.
        calibration: of the camera.
        detector: what finds produce; the one by colour where not given.
    """

    def __init__(
        self, cell: Cell, picture: Callable[[], Picture], calibration: Calibration, detector: Detector | None = None
    ) -> None:
        self._cell, self._picture, self._calibration = cell, picture, calibration
        self._detector, self._base = detector or detector_of(cell), base_of(cell)
        self.position = calibration.position

    def check(self) -> float:
        """How far the markers on the table are from where the calibration says, m.

        Raises:
            PictureError: the picture can't be used.
            CameraError: they are off: the camera was moved, or is miscalibrated.
        """
        return self_check(self._picture(), self._calibration, self._base)

    def look(self, time: float) -> Sight:
        """What is seen in a new picture."""
        picture = self._picture()
        found = self._detector.find(picture, self._calibration)
        return Sight(time, tuple(fruit_of(self._cell, one) for one in found), picture, tuple(found))


class SceneEyes:
    """In place of a camera where no picture can be drawn: the scene's truth, spread as a calibrated camera's finds are.

    Args:
        scene: that is looked at.
    """

    SPREAD = 0.3e-3
    """Standard deviation of each coordinate, m."""
    SIZE = 0.005
    """The same of diameters, share."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._rng = np.random.default_rng([scene.seed, 0xE7E5])
        self.position = np.array(scene.cell.camera.position)

    def look(self, time: float) -> Sight:
        """All fruit that is not held."""
        found = []
        for fruit in self._scene.truth().fruits.values():
            x, y = fruit.position[:2] + self._rng.normal(0.0, self.SPREAD, 2)
            diameter = fruit.diameter * (1.0 + self._rng.normal(0.0, self.SIZE))
            if not fruit.held:
                found.append(Fruit(float(x), float(y), float(diameter), fruit.kind, fruit.grade or ""))
        return Sight(time, tuple(found))
