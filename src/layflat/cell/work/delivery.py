"""One delivery: trays of produce and empty packs, worked off, and judged."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, replace

from layflat.cell.camera import Camera
from layflat.cell.file.model import Cell
from layflat.cell.plan.order import Choice, Left
from layflat.cell.plan.pick import State
from layflat.cell.scene import Scene
from layflat.cell.scene.truth import Collision
from layflat.cell.vision import Calibration
from layflat.cell.work.eyes import CameraEyes, Eyes, SceneEyes, Sight
from layflat.cell.work.judge import Judge, Verdict, Vision
from layflat.cell.work.packer import Packer, Pick
from layflat.cell.work.station import Station
from layflat.errors import DivergedError, LayflatError, PictureError, RigStoppedError, StoppedError


class Onlooker:
    """Who looks on while a cell works, for progress, films and sheets: a base that does nothing."""

    def begins(self, scene: Scene, camera: Camera | None) -> None:
        """A delivery begins; there is no camera where nothing can be drawn."""

    def cycle(self, time: float) -> None:
        """A control cycle is over, s since the delivery began."""

    def phase(self, choice: Choice, before: State, after: State) -> None:
        """A pick's phase has changed."""

    def looked(self, sight: Sight) -> None:
        """A picture was taken and could be used."""

    def picked(self, pick: Pick) -> None:
        """A pick has ended."""

    def ends(self, delivery: Delivery) -> None:
        """The delivery is over and judged; the scene is still there."""


@dataclass(frozen=True, eq=False)
class Delivery:
    """What came of a delivery.

    Attributes:
        seed: of its scene.
        picks: in order.
        verdicts: of each pick.
        left: what was not picked, and why.
        collisions: of arm, lift or cup with what they should not touch.
        time: from the first look to the last, s.
        vision: how well was seen what lay in the trays.
        overlooked: fruit that could have been packed and was not, when nothing more could be picked; None where the
            delivery ended before.
        error: what ended it before its time; None where nothing did.
    """

    seed: int
    picks: tuple[Pick, ...]
    verdicts: tuple[Verdict, ...]
    left: tuple[Left, ...]
    collisions: tuple[Collision, ...]
    time: float
    vision: Vision
    overlooked: int | None = None
    error: LayflatError | None = None

    @property
    def without_pictures(self) -> Delivery:
        """The same but for its pictures, of which a hundred picks have half a GB."""
        picks = [replace(pick, sight=replace(pick.sight, picture=None, detections=())) for pick in self.picks]
        return replace(self, picks=tuple(picks))


def deliver(cell: Cell, seed: int, most: int, calibration: Calibration | None, onlooker: Onlooker) -> Delivery:
    """Work off one delivery.

    Args:
        cell: its description.
        seed: of the scene, the camera's and the sensors' noise.
        most: picks after which it ends.
        calibration: of the camera, against which it is checked before anything moves; None where there is no camera:
            the scene then tells where fruit lies.
        onlooker: looks on.

    Raises:
        PictureError: the camera gives no picture that can be used.
        CameraError: it is not where its calibration says.
        CellError: the scene can't be made.
    """
    scene = Scene(cell, seed)
    with ExitStack() as stack:
        camera = None if calibration is None else stack.enter_context(Camera(scene))
        eyes: Eyes = SceneEyes(scene)
        if camera is not None and calibration is not None:
            eyes = CameraEyes(cell, camera.picture, calibration)
            eyes.check()
        onlooker.begins(scene, camera)
        delivery = _worked(scene, eyes, most, onlooker)
        onlooker.ends(delivery)
    return delivery


def _worked(scene: Scene, eyes: Eyes, most: int, onlooker: Onlooker) -> Delivery:
    cell, seed = scene.cell, scene.seed
    station = Station(scene, seed, lambda: onlooker.cycle(station.time))
    judge = Judge(scene)
    packer = Packer(cell, station, eyes, (judge, onlooker))
    picks: list[Pick] = []
    error: LayflatError | None = None
    try:
        for pick in packer.work(most):
            picks.append(pick)
            judge.ended()
            onlooker.picked(pick)
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
        tuple(judge.verdicts(picks)),
        packer.left,
        judge.collisions,
        station.time,
        judge.vision,
        judge.overlooked(packer.packing) if worked_off else None,
        error,
    )
