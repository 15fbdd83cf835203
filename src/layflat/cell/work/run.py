"""A run of the cell: as many deliveries, trays of produce and empty containers, as it takes for a number of picks.

Runs with many seeds go on all cores.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import wait
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing import get_context
from queue import Queue

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.perception import CameraPerception, Perception, ScenePerception, calibrate_scene
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Calibration
from layflat.cell.work.belt_packer import packer_of
from layflat.cell.work.evaluation import Evaluator
from layflat.cell.work.observer import Observer, Observers, PickCounter
from layflat.cell.work.records import Delivery, Pick
from layflat.cell.work.station import Station
from layflat.errors import CellError, DivergedError, LayflatError, PictureError, RigStoppedError, StoppedError
from layflat.machine import load
from layflat.parallel import process_pool

# Of trays, and of a conveyor.
NOTHING = "there is nothing in the trays", "nothing came on the conveyor"
RIGHT = "lay produce into them that a container takes", "let produce come within reach that a container takes"


@dataclass(frozen=True, eq=False)
class Run:
    """Outcome of a run."""

    cell: Cell
    seed: int
    deliveries: tuple[Delivery, ...]  # in order, without their pictures
    calibration: Calibration | None  # of the camera; None where there was none
    error: LayflatError | None = None  # what ended it early, if anything did


def calibrated(cell: Cell, progress: Callable[[float], object] = lambda _: None) -> Calibration:
    """Calibrate the cell's camera, in a scene of its own; raise as `SimulatedCamera` and `calibrate_scene`."""
    scene = Scene(cell, 0)
    with SimulatedCamera(scene) as camera:
        return calibrate_scene(scene, camera, progress)


def packed(cell: Cell, seed: int, picks: int, calibration: Calibration | None, observer: Observer) -> Run:
    """Pick, delivery after delivery, until there were so many picks or one ended early.

    Same cell, seed and calibration, same run. It ends where a delivery has nothing that can be picked, or with an error
    of any delivery but the first, of which these are raised: PictureError if the camera gives no image that can be
    used, CameraError if it has moved, which is checked before anything else does, CellError if the scene can't be made.
    """
    deliveries: list[Delivery] = []
    error, done = None, 0
    while done < picks and error is None:
        drawn = int(np.random.SeedSequence((seed, len(deliveries))).generate_state(1)[0])
        try:
            delivery = _delivered(cell, drawn, picks - done, calibration, observer)
        except (LayflatError, KeyboardInterrupt) as raised:
            if not deliveries:
                raise
            error = StoppedError(f"{done} picks") if isinstance(raised, KeyboardInterrupt) else raised
            break
        deliveries.append(delivery.without_pictures)
        done += len(delivery.picks)
        error = delivery.error
        if not delivery.picks:
            why = sorted({one.reason for one in delivery.not_picked})
            reason = f"nothing can be picked: {'; '.join(why)}" if why else NOTHING[cell.conveyor is not None]
            error = CellError(reason, where=cell.origin, right=RIGHT[cell.conveyor is not None])
    return Run(cell, seed, tuple(deliveries), calibration, error)


def _delivered(cell: Cell, seed: int, most: int, calibration: Calibration | None, observer: Observer) -> Delivery:
    """Work off one delivery of up to `most` picks; without a calibrated camera the scene's truth stands in for it."""
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
    station = Station(scene, scene.seed, lambda: observer.cycle(station.time))
    evaluator = Evaluator(scene)
    observers = Observers(evaluator, observer)
    packer = packer_of(scene.cell, station, perception, observers)
    picks: list[Pick] = []
    error: LayflatError | None = None
    try:
        for pick in packer.work(most):
            picks.append(pick)
            observers.picked(pick)
        packer.finish()
    except (PictureError, RigStoppedError, DivergedError, KeyboardInterrupt) as raised:
        if not picks:
            raise
        error = StoppedError(f"{len(picks)} picks") if isinstance(raised, KeyboardInterrupt) else raised
    worked_off = error is None and len(picks) < most
    return Delivery(
        scene.seed, tuple(picks), tuple(evaluator.verdicts(picks)), packer.not_picked, scene.truth().collisions,
        station.time, evaluator.vision, evaluator.overlooked(packer.packing) if worked_off else None, error,
    )  # fmt: skip


POLL = 0.2  # between two checks of how far the others are, s


def repeated(
    cell: Cell, seeds: Sequence[int], picks: int, calibration: Calibration | None,
    progress: Callable[[int], object] = lambda _: None, processes: int | None = None, machines: Sequence[str] = (),
) -> Iterator[Run]:  # fmt: skip
    """Yield runs with all seeds, each the same as alone, as they end; raise as `packed`.

    Whoever stops iterating stops the work, and Ctrl-C does: runs that had not ended are lost. `progress` is called with
    the picks that have ended so far; by default there is one process a processor. Where `machines` are named, each seed
    packs with the one at its number.
    """
    with get_context("spawn").Manager() as manager, process_pool(processes, _draw_on_one_core) as submit:
        ended, done = manager.Queue(), 0
        left = {submit(_one, _with(cell, machines, seed), seed, picks, calibration, ended) for seed in seeds}
        while left:
            jobs, left = wait(left, timeout=POLL)
            while not ended.empty():
                done += ended.get()
            progress(done)
            for job in jobs:
                yield job.result()


def _draw_on_one_core() -> None:
    os.environ.setdefault("LP_NUM_THREADS", "1")  # there are as many processes as cores


def _with(cell: Cell, machines: Sequence[str], seed: int) -> Cell:
    return cell.model_copy(update={"machine": load(machines[seed % len(machines)])}) if machines else cell


def _one(cell: Cell, seed: int, picks: int, calibration: Calibration | None, ended: Queue[int]) -> Run:
    return packed(cell, seed, picks, calibration, PickCounter(lambda _: ended.put(1)))
