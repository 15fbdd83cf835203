"""Accuracy and speed with which the packing cell's own camera sees produce, over random scenes.

    python -m benchmarks.cell_camera --scenes 200

Light, fruit, which may touch, and clutter are drawn by the seed; plums are unknown to vision. Two
scenes in three have fruit in the tray, the others in the containers. The camera is calibrated from pictures first, as
on a rig.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from layflat.cell import Cell, load
from layflat.cell.extras import mujoco, opencv
from layflat.cell.kinds import make_detector
from layflat.cell.perception import calibrate_scene, classify_fruit
from layflat.cell.scene import FruitTruth, Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import SURE_CONFIDENCE, Calibration, Detection, draw_detections

NEAR = 0.5
"""Of a fruit's radius, within which a detection is of it."""


@dataclass
class Tally:
    """Counts of produce that was there and was seen."""

    fruit: int = 0
    unknown: int = 0
    unknown_reported: int = 0
    unknown_nothing: list[str] = field(default_factory=list)
    unsure: int = 0
    missed: list[str] = field(default_factory=list)
    false: list[str] = field(default_factory=list)
    doubtful: list[str] = field(default_factory=list)
    kind: list[str] = field(default_factory=list)
    graded: int = 0
    ungraded: int = 0
    grade: list[str] = field(default_factory=list)
    place: list[str] = field(default_factory=list)
    off: list[float] = field(default_factory=list)
    wide: list[float] = field(default_factory=list)

    def compare(self, cell: Cell, seed: int, truth: dict[str, FruitTruth], found: list[Detection]) -> None:
        """Add what was seen in a scene."""
        seen: set[str] = set()
        for one in found:
            name = _nearest(truth, one)
            words = f"scene {seed}: {one.kind} at {one.position[0]:.3f}, {one.position[1]:.3f} m"
            if name is None or (one.kind is not None and name in seen):
                if one.confidence < SURE_CONFIDENCE:
                    self.doubtful.append(f"{words}, {one.confidence:.2f}")
                elif one.kind is not None:
                    self.false.append(words)
                else:
                    self.unknown_nothing.append(words)
                continue
            fruit = truth[name]
            known = cell.produce[fruit.kind].recognised
            if one.kind is None:
                self.unknown_reported += not known
                continue
            seen.add(name)
            if one.confidence < SURE_CONFIDENCE:
                self.unsure += 1
            elif not known:
                self.false.append(f"{words}: {name}")
            elif one.kind != fruit.kind:
                self.kind.append(f"{words}: {name}")
            else:
                self._measured(cell, words, fruit, one)
        known_ones = {name for name, fruit in truth.items() if cell.produce[fruit.kind].recognised}
        self.fruit += len(known_ones)
        self.unknown += len(truth) - len(known_ones)
        self.missed += [f"scene {seed}: {name}" for name in sorted(known_ones - seen)]

    def _measured(self, cell: Cell, words: str, fruit: FruitTruth, one: Detection) -> None:
        self.off.append(1e3 * float(np.hypot(*(fruit.position[:2] - one.position[:2]))))
        self.wide.append(100.0 * (one.diameter / fruit.diameter - 1.0))
        graded = classify_fruit(cell, one)
        self.graded += not graded.ungraded_reason
        self.ungraded += bool(graded.ungraded_reason) and fruit.grade is not None
        if not graded.ungraded_reason and graded.grade != fruit.grade:
            self.grade.append(f"{words}: {graded.grade}, is {fruit.grade}")
        place = cell.place_at(*one.position[:2])
        if place != fruit.place:
            self.place.append(f"{words}: {place}, is {fruit.place}")


def _nearest(truth: dict[str, FruitTruth], one: Detection) -> str | None:
    gaps = {
        name: float(np.hypot(*(fruit.position[:2] - one.position[:2]))) / (0.5 * fruit.diameter)
        for name, fruit in truth.items()
    }
    name = min(gaps, key=lambda fruit: gaps[fruit], default=None)
    return name if name is not None and gaps[name] < NEAR else None


def with_unknown(cell: Cell) -> Cell:
    """The cell with unknown fruit in its trays."""
    unknown = tuple(name for name, kind in cell.produce.items() if not kind.recognised)
    trays = {
        name: tray.model_copy(update={"produce": (*tray.produce, *unknown)}) for name, tray in cell.tray.items()
    }  # fmt: skip
    return cell.model_copy(update={"tray": trays})


def cluttered(cell: Cell, times: int) -> Cell:
    """The cell with so many times as much clutter."""
    more = {
        name: one.model_copy(update={"count": one.count.model_copy(update={"max": times * one.count.max})})
        for name, one in cell.clutter.items()
    }
    return cell.model_copy(update={"clutter": more})


def pack_all(scene: Scene, rng: np.random.Generator) -> None:
    """Lay the tray's fruit into random places of containers that take it, and let it rest there."""
    data, model, cell = scene.data, scene.model, scene.cell
    free = [(name, *spot) for name, one in cell.container.items() for spot in one.places.tolist()]
    rng.shuffle(free)
    for fruit in scene.fruits:
        at = next((spot for spot in free if cell.container[spot[0]].layout.opening >= fruit.diameter), None)
        if at is None:
            continue
        free.remove(at)
        start = int(model.joint(fruit.name).qposadr[0])
        height = cell.container[at[0]].layout.wall + fruit.height_below + 1e-3
        data.qpos[start : start + 7] = [*at[1:], height, 1.0, 0.0, 0.0, 0.0]
    mujoco().mj_forward(model, data)
    scene.step(400)


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--scenes", type=int, default=200)
    asked.add_argument("--seed", type=int, default=0)
    asked.add_argument("--clutter", type=int, default=1, help="so many times as much clutter")
    asked.add_argument("--draw", type=Path, help="folder for pictures with detections drawn")
    options = asked.parse_args()
    cell = cluttered(with_unknown(load("packing")), options.clutter)
    tallies, spent, calibration = {"tray": Tally(), "containers": Tally()}, [], None
    detector = make_detector(cell)
    opencv().setNumThreads(1)
    shown = Console(stderr=True)
    scenes = range(options.seed, options.seed + options.scenes)
    for seed in track(scenes, "scenes", console=shown, disable=not shown.is_terminal):
        scene = Scene(cell, seed)
        where = "containers" if seed % 3 == 2 else "tray"
        if where == "containers":
            pack_all(scene, np.random.default_rng(seed))
        with SimulatedCamera(scene) as camera:
            if calibration is None:
                calibration = calibrate_scene(scene, camera)
                detector.detect(camera.picture(), calibration)
            picture = camera.picture()
        wall, processor = time.perf_counter(), time.process_time()
        found = detector.detect(picture, calibration)
        spent.append((time.perf_counter() - wall, time.process_time() - processor))
        tallies[where].compare(cell, seed, scene.truth().fruits, found)
        if options.draw:
            _keep(options.draw, seed, picture, found)
    assert calibration is not None
    _report(tallies, np.array(spent), options.scenes, calibration)


def _keep(folder: Path, seed: int, picture: np.ndarray, found: list[Detection]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    opencv().imwrite(str(folder / f"{seed:04d}.png"), draw_detections(picture, found)[..., ::-1])


def _report(tallies: dict[str, Tally], spent: np.ndarray, scenes: int, calibration: Calibration) -> None:
    width, height = calibration.picture_px
    table = Table("", *(f"in the {name}" for name in tallies), title=f"{scenes} scenes, {width} x {height} px")
    rows = {
        "fruit": lambda one: f"{one.fruit}",
        "seen surely, unsurely, not": lambda one: f"{len(one.off)}, {one.unsure}, {len(one.missed)}",
        "false picks": lambda one: f"{len(one.false)}",
        "sure unknown objects where nothing is": lambda one: f"{len(one.unknown_nothing)}",
        "unsure detections of nothing": lambda one: f"{len(one.doubtful)}",
        "of unknown kind, reported as such": lambda one: f"{one.unknown_reported} of {one.unknown}",
        "wrong kind": lambda one: f"{len(one.kind)}",
        "graded, wrongly, not though it has one": lambda one: f"{one.graded}, {len(one.grade)}, {one.ungraded}",
        "wrong place in a container": lambda one: f"{len(one.place)}",
        "position: median, 95 %, worst": lambda one: "{:.2f}, {:.2f}, {:.2f} mm".format(
            *np.quantile(one.off, (0.5, 0.95, 1))
        ),
        "diameter: mean; size 95 %, worst": lambda one: "{:+.2f}; {:.2f}, {:.2f} %".format(
            np.mean(one.wide), *np.quantile(np.abs(one.wide), (0.95, 1))
        ),
    }
    for name, words in rows.items():
        table.add_row(name, *(words(one) if one.off else "-" for one in tallies.values()))
    wall, processor = 1e3 * np.median(spent, axis=0)
    table.add_row("a picture on one core: wall clock, processor", f"{wall:.1f}, {processor:.1f} ms", "")
    console = Console(width=100)
    console.print(table)
    for one in tallies.values():
        for title in ("doubtful", "unknown_nothing", "missed", "false", "kind", "grade", "place"):
            for line in getattr(one, title):
                console.print(f"{title}: {line}")


if __name__ == "__main__":
    main()
