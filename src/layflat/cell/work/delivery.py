"""One delivery: trays of produce and empty containers, worked off, and evaluated."""

from __future__ import annotations

from contextlib import ExitStack

from layflat.cell.file.model import Cell
from layflat.cell.perception import CameraPerception, Perception, ScenePerception
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Calibration
from layflat.cell.work.evaluation import Evaluator
from layflat.cell.work.observer import Observer, Observers
from layflat.cell.work.packer import Packer
from layflat.cell.work.records import Delivery, Pick
from layflat.cell.work.station import Station
from layflat.errors import DivergedError, LayflatError, PictureError, RigStoppedError, StoppedError


def deliver(cell: Cell, seed: int, most: int, calibration: Calibration | None, observer: Observer) -> Delivery:
    """Work off one delivery.

    Args:
        cell: its description.
        seed: of the scene, the camera's and the sensors' noise.
        most: picks after which it ends.
        calibration: of the camera, against which it is checked before anything moves; None where there is no camera:
            the scene's truth then stands in for it.
        observer: observes the work.

    Raises:
        PictureError: the camera gives no image that can be used.
        CameraError: it is not where its calibration says.
        CellError: the scene can't be made.
    """
    scene = Scene(cell, seed)
    with ExitStack() as stack:
        camera = None if calibration is None else stack.enter_context(SimulatedCamera(scene))
        perception: Perception = ScenePerception(scene)
        if camera is not None and calibration is not None:
            perception = CameraPerception(cell, camera.picture, calibration)
            perception.check()
        observer.begins(scene, camera)
        delivery = _worked(scene, perception, most, observer)
        observer.ends(delivery)
    return delivery


def _worked(scene: Scene, perception: Perception, most: int, observer: Observer) -> Delivery:
    cell, seed = scene.cell, scene.seed
    station = Station(scene, seed, lambda: observer.cycle(station.time))
    evaluator = Evaluator(scene)
    observers = Observers(evaluator, observer)
    packer = Packer(cell, station, perception, observers)
    picks: list[Pick] = []
    error: LayflatError | None = None
    try:
        for pick in packer.work(most):
            picks.append(pick)
            observers.picked(pick)
        packer.finish()
    except (PictureError, RigStoppedError, DivergedError) as raised:
        if not picks:
            raise
        error = raised
    except KeyboardInterrupt:
        if not picks:
            raise
        error = StoppedError(f"{len(picks)} picks")
    worked_off = error is None and len(picks) < most
    return Delivery(
        seed,
        tuple(picks),
        tuple(evaluator.verdicts(picks)),
        packer.not_picked,
        evaluator.collisions,
        station.time,
        evaluator.vision,
        evaluator.overlooked(packer.packing) if worked_off else None,
        error,
    )
