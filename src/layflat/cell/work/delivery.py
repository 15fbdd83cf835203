"""One delivery: trays of produce and empty containers, worked off, and evaluated."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, replace

from layflat.cell.file.model import Cell
from layflat.cell.perception import CameraPerception, Perception, ScenePerception
from layflat.cell.plan.order import NotPicked
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.scene.truth import Collision
from layflat.cell.vision import Calibration
from layflat.cell.work.evaluation import Evaluator, Verdict, VisionErrors
from layflat.cell.work.observer import Observer, Observers
from layflat.cell.work.packer import Packer, Pick
from layflat.cell.work.station import Station
from layflat.errors import DivergedError, LayflatError, PictureError, RigStoppedError, StoppedError


@dataclass(frozen=True, eq=False)
class Delivery:
    """What came of a delivery.

    Attributes:
        seed: of its scene.
        picks: in order.
        verdicts: of each pick.
        not_picked: what was not picked, and why.
        collisions: of arm, lift or cup with what they should not touch.
        time: from the first image to the last, s.
        vision: errors in what lay in the trays.
        overlooked: fruit that could have been packed and was not, when nothing more could be picked; None where the
            delivery ended before.
        error: what ended it early; None where nothing did.
    """

    seed: int
    picks: tuple[Pick, ...]
    verdicts: tuple[Verdict, ...]
    not_picked: tuple[NotPicked, ...]
    collisions: tuple[Collision, ...]
    time: float
    vision: VisionErrors
    overlooked: int | None = None
    error: LayflatError | None = None

    @property
    def without_pictures(self) -> Delivery:
        """The same but for its pictures, of which a hundred picks have half a GB."""
        picks = [
            replace(pick, observation=replace(pick.observation, picture=None, detections=())) for pick in self.picks
        ]
        return replace(self, picks=tuple(picks))


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
