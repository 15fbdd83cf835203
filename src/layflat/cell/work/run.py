"""A run of the cell: as many deliveries as it takes for a number of picks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.perception import calibrate_scene
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Calibration
from layflat.cell.work.delivery import deliver
from layflat.cell.work.observer import Observer
from layflat.cell.work.records import Delivery
from layflat.errors import CellError, LayflatError


@dataclass(frozen=True, eq=False)
class Run:
    """What came of a run.

    Attributes:
        cell: in which it was.
        seed: as given.
        deliveries: in order, without their pictures.
        calibration: of the camera; None where there was none.
        error: what ended it early, if anything did.
    """

    cell: Cell
    seed: int
    deliveries: tuple[Delivery, ...]
    calibration: Calibration | None
    error: LayflatError | None = None


def calibrated(cell: Cell, progress: Callable[[float], None] | None = None) -> Calibration:
    """Calibrate the cell's camera, in a scene of its own.

    Raises:
        NoDrawingError: there is no OpenGL to render with.
        PictureError: a picture can't be used.
        CameraError: board or markers are not detected.
    """
    scene = Scene(cell, 0)
    with SimulatedCamera(scene) as camera:
        return calibrate_scene(scene, camera, progress)


def packed(cell: Cell, seed: int, picks: int, calibration: Calibration | None, observer: Observer) -> Run:
    """Pick, delivery after delivery, until there were so many picks or one ended early.

    Same cell, seed and calibration, same run. It ends where a delivery has nothing that can be picked.

    Raises:
        PictureError, CameraError, CellError: as `deliver`, of the first delivery; those of others end the run.
    """
    deliveries: list[Delivery] = []
    error, done = None, 0
    while done < picks and error is None:
        drawn = int(np.random.SeedSequence((seed, len(deliveries))).generate_state(1)[0])
        try:
            delivery = deliver(cell, drawn, picks - done, calibration, observer)
        except LayflatError as raised:
            if not deliveries:
                raise
            error = raised
            break
        deliveries.append(delivery.without_pictures)
        done += len(delivery.picks)
        error = delivery.error or _nothing_in(delivery, cell)
    return Run(cell, seed, tuple(deliveries), calibration, error)


def _nothing_in(delivery: Delivery, cell: Cell) -> LayflatError | None:
    """Return why nothing was picked, where nothing was."""
    if delivery.picks:
        return None
    why = sorted({one.reason for one in delivery.not_picked})
    reason = f"nothing can be picked: {'; '.join(why)}" if why else "there is nothing in the trays"
    return CellError(reason, where=cell.origin, right="lay produce into them that a container takes")
