"""Runs of the cell: as many deliveries (trays of produce and empty containers) as a number of picks needs.

Runs with many seeds use all cores.
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
from layflat.cell.work.belt_packer import make_packer
from layflat.cell.work.evaluation import Evaluator
from layflat.cell.work.observer import Delivery, Observer, Observers, Pick, PickCounter
from layflat.cell.work.station import CellStation
from layflat.errors import CellError, DivergedError, LayflatError, PictureError, RigStoppedError, StoppedError
from layflat.machine import load
from layflat.parallel import process_pool

# Of trays, and of a conveyor.
EMPTY_REASONS = "there is nothing in the trays", "nothing came on the conveyor"
EMPTY_ADVICE = "lay produce into them that a container takes", "let produce come within reach that a container takes"


@dataclass(frozen=True, eq=False)
class PackingRun:
    """Result of a run of the cell."""

    cell: Cell
    seed: int
    deliveries: tuple[Delivery, ...]  # in order, without their pictures
    calibration: Calibration | None  # of the camera; None where there was none
    error: LayflatError | None = None  # that ended it early, if any


def calibrate_cell(cell: Cell, progress: Callable[[float], object] = lambda _: None) -> Calibration:
    """Calibrate the cell's camera in a scene with seed 0; raise as `SimulatedCamera` and `calibrate_scene`."""
    scene = Scene(cell, 0)
    with SimulatedCamera(scene) as camera:
        return calibrate_scene(scene, camera, progress)


def run_packing(cell: Cell, seed: int, picks: int, calibration: Calibration | None, observer: Observer) -> PackingRun:
    """Simulate deliveries until a number of picks, or until one ends early; reproducible.

    The run ends where a delivery has no fruit that can be picked, or with an error or
    Ctrl-C after the first pick, which is then its `error`.

    Args:
        cell: description.
        seed: seed of all deliveries.
        picks: number of picks.
        calibration: calibration of the camera; None: the scene's truth with noise in place of images.
        observer: notified of each event.

    Raises:
        PictureError: the camera gives no usable image before the first pick.
        CameraError: the camera has moved, which is checked first.
        CellError: the scene can't be built.
        RigStoppedError, DivergedError: the arm stopped, or the simulation diverged, before the first pick.
    """
    deliveries: list[Delivery] = []
    error, done = None, 0
    while done < picks and error is None:
        delivery_seed = int(np.random.SeedSequence((seed, len(deliveries))).generate_state(1)[0])
        try:
            delivery = _run_delivery(cell, delivery_seed, picks - done, calibration, observer)
        except (LayflatError, KeyboardInterrupt) as raised:
            if not deliveries:
                raise
            error = StoppedError(f"{done} picks") if isinstance(raised, KeyboardInterrupt) else raised
            break
        deliveries.append(delivery.without_pictures)
        done += len(delivery.picks)
        error = delivery.error
        if not delivery.picks:
            reasons = sorted({not_picked.reason for not_picked in delivery.not_picked})
            reason = (
                f"nothing can be picked: {'; '.join(reasons)}" if reasons else EMPTY_REASONS[cell.conveyor is not None]
            )
            error = CellError(reason, where=cell.origin, right=EMPTY_ADVICE[cell.conveyor is not None])
    return PackingRun(cell, seed, tuple(deliveries), calibration, error)


def _run_delivery(
    cell: Cell, seed: int, max_picks: int, calibration: Calibration | None, observer: Observer
) -> Delivery:
    """Simulate one delivery of up to `max_picks` picks, with the calibrated camera, else with the scene's truth."""
    scene = Scene(cell, seed)
    with ExitStack() as stack:
        camera = None if calibration is None else stack.enter_context(SimulatedCamera(scene))
        perception: Perception = ScenePerception(scene)
        if camera is not None and calibration is not None:
            perception = CameraPerception(cell, camera.picture, calibration)
            perception.check()
        observer.on_delivery_start(scene, camera)
        delivery = _work_delivery(scene, perception, max_picks, observer)
        observer.on_delivery_end(delivery)
    return delivery


def _work_delivery(scene: Scene, perception: Perception, max_picks: int, observer: Observer) -> Delivery:
    """Return the result of packing one delivery, at most `max_picks`.

    An error or Ctrl-C after the first pick ends the delivery, which then has the error; before it, it is raised.
    """

    def notify() -> None:
        """Notify the observer of a control cycle."""
        observer.on_cycle_record(station.arm.layout, station.arm.row)
        observer.on_control_cycle(station.time)

    station = CellStation(scene, scene.seed, notify)
    evaluator = Evaluator(scene)
    observers = Observers(evaluator, observer)
    packer = make_packer(scene.cell, station, perception, observers)
    picks: list[Pick] = []
    error: LayflatError | None = None
    try:
        for pick in packer.work(max_picks):
            picks.append(pick)
            observers.on_pick_end(pick)
        packer.finish()
    except (PictureError, RigStoppedError, DivergedError, KeyboardInterrupt) as raised:
        if not picks:
            raise
        error = StoppedError(f"{len(picks)} picks") if isinstance(raised, KeyboardInterrupt) else raised
    finished = error is None and len(picks) < max_picks
    return Delivery(
        scene.seed, tuple(picks), tuple(evaluator.verdicts(picks)), packer.not_picked, scene.truth().collisions,
        station.time, evaluator.vision, evaluator.overlooked(packer.packing) if finished else None, error,
    )  # fmt: skip


POLL_PERIOD = 0.2  # between two checks of the processes' progress, s


def run_seeds(
    cell: Cell, seeds: Sequence[int], picks: int, calibration: Calibration | None,
    progress: Callable[[int], object] = lambda _: None, processes: int | None = None, machines: Sequence[str] = (),
) -> Iterator[PackingRun]:  # fmt: skip
    """Yield the runs of all seeds as they end, each the same as `run_packing` returns.

    The end of the iteration or Ctrl-C stops the work: unfinished runs are lost.

    Args:
        cell: description.
        seeds: seeds of the runs.
        picks: number of picks of each.
        calibration: calibration of the camera; None: the scene's truth with noise in place of images.
        progress: called with the number of picks of all runs so far.
        processes: number of processes; default: one for each processor.
        machines: names of machines, of which seed n uses number n modulo their count; default: the cell's.

    Raises:
        LayflatError: of any run, as `run_packing`; runs that have not been yielded are lost.
    """
    with get_context("spawn").Manager() as manager, process_pool(processes, _draw_on_one_core) as submit:
        ended, done = manager.Queue(), 0
        pending = {
            submit(_run_seed, _with_machine(cell, machines, seed), seed, picks, calibration, ended) for seed in seeds
        }
        while pending:
            jobs, pending = wait(pending, timeout=POLL_PERIOD)
            while not ended.empty():
                done += ended.get()
            progress(done)
            for job in jobs:
                yield job.result()


def _draw_on_one_core() -> None:
    os.environ.setdefault("LP_NUM_THREADS", "1")  # there are as many processes as cores


def _with_machine(cell: Cell, machines: Sequence[str], seed: int) -> Cell:
    return cell.model_copy(update={"machine": load(machines[seed % len(machines)])}) if machines else cell


def _run_seed(cell: Cell, seed: int, picks: int, calibration: Calibration | None, ended: Queue[int]) -> PackingRun:
    return run_packing(cell, seed, picks, calibration, PickCounter(lambda _: ended.put(1)))
