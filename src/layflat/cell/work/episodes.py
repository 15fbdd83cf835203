"""Picks as episodes of a LeRobot data set: camera images, sensors of arm, lift and cup, and their commands."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from math import isclose
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.cell.file.model import Cell
from layflat.cell.perception import Observation
from layflat.cell.plan.order import Fruit
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.work.observer import Delivery, Observer, Pick
from layflat.errors import InputError
from layflat.lerobot import CameraFeature, EpisodeWriter, VectorFeature
from layflat.lerobot.writer import MAX_FPS, check_fps, check_target
from layflat.rig.record import RowLayout

STATE_KEY, ACTION_KEY = "observation.state", "action"
CAMERA_VIEWS = {"observation.images.camera": "camera", "observation.images.overview": "overview"}
"""Views of the simulated camera by feature."""


class EpisodeRecorder(Observer):
    """Observer that adds each pick to a data set, from its choice to the release of the fruit.

    It has a camera of its own, so that the images that the cell takes keep their noise.
    """

    def __init__(self, writer: EpisodeWriter, cell: Cell, *, pictures: bool) -> None:
        """Store the writer; `pictures`: whether images can be rendered."""
        self._writer, self._pictures = writer, pictures
        self._cycles_per_frame = cycles_per_frame(cell.machine.cycle, writer.fps)
        self._scene: Scene | None = None
        self._camera: SimulatedCamera | None = None
        self._rows: dict[str, list[Array]] | None = None  # of the present pick; None between picks
        self._cycles = 0  # since the pick began

    def on_delivery_start(self, scene: Scene, camera: SimulatedCamera | None) -> None:  # noqa: ARG002  (as all observers)
        """Open a camera for the delivery's scene."""
        self.close()
        self._scene = scene
        self._camera = SimulatedCamera(scene) if self._pictures else None

    def on_pick_start(self, fruit: Fruit, observation: Observation) -> None:  # noqa: ARG002  (as all observers)
        """Start an episode."""
        self._writer.start_episode()
        self._rows, self._cycles = {STATE_KEY: [], ACTION_KEY: []}, 0

    def on_cycle_record(self, layout: RowLayout, row: Array) -> None:
        """Add a frame, if one is due: sensors and commands of this cycle, and images."""
        if self._rows is None or self._scene is None:
            return
        if self._cycles % self._cycles_per_frame == 0:
            lift, cup, top = self._scene.lift, self._scene.cup, self._scene.cell.lift.clearance
            sensed = layout.named(row, "measured_angle"), layout.named(row, "measured_pressure")
            self._rows[STATE_KEY].append(np.concatenate([*sensed, [top - self._scene.stroke, cup.vacuum]]))
            self._rows[ACTION_KEY].append(np.concatenate([layout.named(row, "demand"), [top - lift.demand, cup.on]]))
            if self._camera is not None:
                for key, view in CAMERA_VIEWS.items():
                    self._writer.add_picture(key, self._camera.picture(view))  # type: ignore[arg-type]  # a view
        self._cycles += 1

    def on_pick_end(self, pick: Pick) -> None:
        """Add the pick with its task and, as a label, its outcome by the cell's own sensors."""
        if self._rows is None or not self._rows[STATE_KEY]:
            return
        fruit, place = pick.choice.fruit, pick.choice.place
        task = f"pack the {fruit.kind} of grade {fruit.grade} into place {place.name} of {place.container}"
        values = {name: np.stack(rows) for name, rows in self._rows.items()}
        self._writer.add_episode(task, values, {"outcome": pick.outcome.name.lower()})
        self._rows = None

    def on_delivery_end(self, delivery: Delivery) -> None:  # noqa: ARG002  (as all observers)
        """Close the delivery's camera."""
        self.close()

    def close(self) -> None:
        """Free the camera, and leave out a pick that has not ended."""
        if self._camera is not None:
            self._camera.close()
        self._camera = self._rows = None


def cycles_per_frame(cycle: float, fps: int) -> int:
    """Return the control cycles (s) of a frame; raise InputError for a rate with which they are no whole number."""

    def whole_cycles(rate: int) -> int:
        """Return the control cycles of a frame at a rate; 0 if they are no whole number."""
        cycles = 1.0 / (rate * cycle)
        return round(cycles) if isclose(cycles, round(cycles), rel_tol=1e-9) else 0

    if cycles := whole_cycles(check_fps(fps)):
        return cycles
    rates = ", ".join(str(rate) for rate in range(1, MAX_FPS + 1) if whole_cycles(rate))
    what = f"{fps} frames a second fall between control cycles of {1e3 * cycle:g} ms"
    raise InputError(what, where="fps", right=f"give {rates}" if rates else "give a machine with another cycle")


def cell_features(cell: Cell) -> dict[str, VectorFeature]:
    """Return the features of numbers of a cell: joints, lift and cup."""
    joints = list(cell.machine.joints)

    def join(signals: dict[str, str], others: dict[str, str]) -> VectorFeature:
        """Return the feature of signals of the joints and of others, both with their units."""
        names = [f"{signal}.{joint}" for signal in signals for joint in joints]
        units = [unit for unit in signals.values() for _ in joints]
        return VectorFeature((*names, *others), (*units, *others.values()))

    return {
        STATE_KEY: join({"angle": "rad", "measured_pressure": "Pa"}, {"lift.height": "m", "cup.vacuum": "Pa"}),
        ACTION_KEY: join({"demand": "rad"}, {"lift.height": "m", "cup.suction": "1"}),
    }


class _NoPickError(Exception):
    """No pick has ended: there is nothing to write."""


@contextmanager
def record_episodes(folder: Path, cell: Cell, fps: int, *, pictures: bool) -> Iterator[EpisodeRecorder]:
    """Yield an observer that makes a LeRobot data set, which is written if the block ends without an error.

    Args:
        folder: new or empty folder; without a pick none is made.
        cell: description.
        fps: frames a second, each after a whole number of control cycles.
        pictures: whether images can be rendered.

    Raises:
        InputError: a frame would fall between control cycles.
        MissingExtraError: pyarrow or PyAV is not installed.
        OutputError: the folder is not empty, or can't be written.
    """
    check_target(folder)
    sizes = {"camera": (cell.camera.height, cell.camera.width), "overview": (cell.overview.height, cell.overview.width)}
    cameras = {key: CameraFeature(*sizes[view]) for key, view in CAMERA_VIEWS.items()}
    writer = EpisodeWriter(folder, fps, cell.machine.name, cell_features(cell), cameras if pictures else {})
    with suppress(_NoPickError), writer:
        recorder = EpisodeRecorder(writer, cell, pictures=pictures)
        try:
            yield recorder
        finally:
            recorder.close()
        if not writer.summary.episodes:
            raise _NoPickError
