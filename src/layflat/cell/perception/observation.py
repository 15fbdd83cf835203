"""What the cell observes: images and vision, or where no image can be rendered, the scene's own truth with noise.

A detected fruit gets the grade by which it is packed, or the reason why it has none. Its skin is identified by its
chromaticity, r and g of r + g + b = 1, which light and shade leave alone.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from layflat.arrays import Array, Picture
from layflat.cell.file.model import Cell
from layflat.cell.file.produce import Produce, Skin
from layflat.cell.perception.calibrating import base_of
from layflat.cell.perception.kinds import detector_of
from layflat.cell.plan.containers import Fruit
from layflat.cell.scene import Scene
from layflat.cell.vision import Calibration, Detection, self_check

DIAMETER_ERROR = 0.015  # by which vision may be off, share: about the worst of 1800 fruit, see docs/cell-vision.md
TINT = 0.01  # by which a chromaticity may be off: lights of unlike tint
AS_NEAR = 0.6  # ratio of two skins' distances from which they are about as near
UNKNOWN = "unknown"  # kind of an unknown object, which stands in the way all the same


@dataclass(frozen=True, eq=False)
class Observation:
    """One image of the table and what was detected in it."""

    time: float  # s
    fruits: tuple[Fruit, ...]  # all produce that was detected, also in containers and of unknown kinds
    picture: Picture | None = None  # RGB
    detections: tuple[Detection, ...] = ()  # of vision in the picture


class Perception(Protocol):
    """What observes the table from above."""

    position: Array  # of the camera, (3,) m

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
        """Return how far the markers on the table are from where the calibration says, m; raise as `self_check`."""
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
        """Return all fruit in the camera's view that is not held."""
        found = []
        for fruit in self._scene.truth().fruits.values():
            x, y = fruit.position[:2] + self._rng.normal(0.0, self.SPREAD, 2)
            diameter = fruit.diameter * (1.0 + self._rng.normal(0.0, self.SIZE))
            if fruit.here and not fruit.held and self._scene.cell.camera.sees((x, y)):
                found.append(Fruit(float(x), float(y), float(diameter), fruit.kind, fruit.grade or ""))
        return Observation(time, tuple(found))


def fruit_of(cell: Cell, detection: Detection) -> Fruit:
    """Return a detected fruit as plans know it, with its grade or the doubt that leaves it none."""
    grade, doubt = _graded(cell, detection)
    x, y, _ = detection.position
    return Fruit(x, y, detection.diameter, detection.kind or UNKNOWN, grade, detection.confidence, doubt)


def _graded(cell: Cell, detection: Detection) -> tuple[str, str]:
    """Return the grade, and the doubt as a clause; one of them is empty."""
    if detection.kind is None or detection.kind not in cell.produce:
        return "", "is of no kind that is known here"
    produce, diameter = cell.produce[detection.kind], detection.diameter
    skin, other = _skins(produce.colour, detection.colour)
    if other:
        return "", f"could be {skin} or {other}"
    grades = _grades(produce, diameter, skin)
    if len(grades) > 1:
        names = " or ".join(grade or "none" for grade in grades)
        return "", f"is too near to a limit: {1e3 * diameter:.1f} mm may be of grade {names}"
    return (grades[0], "") if grades[0] else ("", f"is of no grade: {skin}, {1e3 * diameter:.0f} mm")


def _skins(skins: Mapping[str, Skin], colour: tuple[float, float, float]) -> tuple[str, str]:
    """Return the nearest skin, in units of its spread with what light adds, and another about as near, if one is."""
    seen = _chromaticity(colour)
    wide = {name: float(np.hypot(0.5 * skin.spread / sum(skin.rgb), TINT)) for name, skin in skins.items()}
    away = {name: float(np.linalg.norm(seen - _chromaticity(skin.rgb))) / wide[name] for name, skin in skins.items()}
    nearest, *others = sorted(away, key=lambda name: away[name])
    return nearest, others[0] if others and away[nearest] > AS_NEAR * away[others[0]] else ""


def _chromaticity(colour: tuple[float, float, float]) -> Array:
    return np.array(colour[:2]) / max(sum(colour), 1e-6)


def _grades(produce: Produce, diameter: float, colour: str) -> list[str | None]:
    """Return the grades that a fruit may have, as far as its diameter is known."""
    low, high = diameter * (1.0 - DIAMETER_ERROR), diameter * (1.0 + DIAMETER_ERROR)
    limits = [limit for grade in produce.grade.values() for limit in (grade.least, grade.most) if low < limit <= high]
    return list(dict.fromkeys(produce.grade_of(at, colour) for at in (low, *sorted(limits))))
