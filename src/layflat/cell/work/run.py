"""A run of the cell: as many deliveries as it takes for a number of picks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from layflat.cell.camera import Camera
from layflat.cell.eyes import calibrate_scene
from layflat.cell.file.model import Cell
from layflat.cell.scene import Scene
from layflat.cell.vision import Calibration
from layflat.cell.work.delivery import Delivery, Onlooker, deliver
from layflat.errors import CellError, LayflatError


@dataclass(frozen=True, eq=False)
class Run:
    """What came of a run.

    Attributes:
        cell: in which it was.
        seed: as given.
        deliveries: in order.
        calibration: of the camera; None where there was none.
    """

    cell: Cell
    seed: int
    deliveries: tuple[Delivery, ...]
    calibration: Calibration | None

    @property
    def error(self) -> LayflatError | None:
        """What ended it before its time, if anything did."""
        last = self.deliveries[-1]
        if last.error is not None or last.picks:
            return last.error
        why = sorted({left.reason for left in last.left})
        told = f"nothing can be picked: {'; '.join(why)}" if why else "there is nothing in the trays"
        return CellError(told, where=self.cell.origin, right="lay produce into them that a pack takes")


def calibrated(cell: Cell, progress: Callable[[float], None] | None = None) -> Calibration:
    """Calibrate the cell's camera, in a scene of its own.

    Raises:
        NoDrawingError: there is no OpenGL to draw with.
        PictureError: a picture can't be used.
        CameraError: board or markers are not seen.
    """
    scene = Scene(cell, 0)
    with Camera(scene) as camera:
        return calibrate_scene(scene, camera, progress)


def packed(cell: Cell, seed: int, picks: int, calibration: Calibration | None, onlooker: Onlooker) -> Run:
    """Pick, delivery after delivery, until there were so many picks or one ended early.

    Same cell, seed and calibration, same run. It ends where a delivery has nothing that can be picked.

    Raises:
        PictureError, CameraError, CellError: as `deliver`.
    """
    deliveries: list[Delivery] = []
    done = 0
    while done < picks:
        drawn = int(np.random.SeedSequence((seed, len(deliveries))).generate_state(1)[0])
        delivery = deliver(cell, drawn, picks - done, calibration, onlooker)
        deliveries.append(delivery)
        done += len(delivery.picks)
        if delivery.error is not None or not delivery.picks:
            break
    return Run(cell, seed, tuple(deliveries), calibration)
