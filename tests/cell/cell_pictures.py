"""A cell, its scene and its calibrated camera, for tests of what is seen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.cell import Cell
from layflat.cell.scene import FruitTruth, Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import SURE_CONFIDENCE, Detection

Picture = NDArray[np.uint8]


def picture_of(scene: Scene) -> Picture:
    with SimulatedCamera(scene) as camera:
        return camera.picture()


def with_camera(cell: Cell, **changes: Any) -> Cell:
    return cell.model_copy(update={"camera": cell.camera.model_copy(update=changes)})


def with_unknown(cell: Cell, *unknown: str) -> Cell:
    tray = cell.tray["infeed"]
    more = tray.model_copy(update={"produce": (*tray.produce, *unknown)})
    return cell.model_copy(update={"tray": {"infeed": more}})


def nearest(found: list[Detection], fruit: FruitTruth) -> Detection:
    return min(found, key=lambda one: float(np.hypot(*(fruit.position[:2] - one.position[:2]))))


def false_picks(found: list[Detection], truth: dict[str, FruitTruth]) -> list[Detection]:
    """Sure detections of a known kind where no such fruit is."""
    return [
        one
        for one in found
        if one.kind is not None
        and one.confidence >= SURE_CONFIDENCE
        and not any(
            fruit.kind == one.kind and np.hypot(*(fruit.position[:2] - one.position[:2])) < fruit.diameter / 4
            for fruit in truth.values()
        )
    ]
