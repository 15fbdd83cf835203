"""How exactly and how fast produce is seen, over random scenes with clutter, touching fruit and changing light.

    python -m benchmarks.cell_vision --scenes 200

The camera is calibrated from pictures first, as on a rig. Scenes are those of the tests, each with a truth of its own.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from layflat.cell.vision import SURE_CONFIDENCE, ColourDetector, Detection
from tests.cell.vision.pictures import Scene, take
from tests.cell.vision.vision_scenes import BACKGROUND, CAMERA, KINDS, TABLE, calibrated, random_scene


@dataclass
class Tally:
    """What was seen of what was there."""

    fruit: int = 0
    unknown: int = 0
    unknown_reported: int = 0
    unsure: int = 0
    missed: int = 0
    false: int = 0
    off: list[float] = field(default_factory=list)
    wide: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)


def compare(scene: Scene, found: list[Detection], tally: Tally) -> None:
    """Add a scene's detections: a sure one that is not over a fruit of its kind is false."""
    seen = set()
    for one in found:
        gaps = [np.hypot(ball.x - one.position[0], ball.y - one.position[1]) / ball.radius for ball in scene.balls]
        at = int(np.argmin(gaps)) if gaps else -1
        right = at >= 0 and gaps[at] < 0.5 and (scene.balls[at].kind or None) == one.kind
        if not right:
            tally.false += one.kind is not None and one.confidence >= SURE_CONFIDENCE
        elif one.kind is None:
            tally.unknown_reported += 1
        else:
            tally.false += at in seen
            seen.add(at)
            if one.confidence < SURE_CONFIDENCE:
                tally.unsure += 1
                continue
            ball = scene.balls[at]
            tally.off.append(1e3 * gaps[at] * ball.radius)
            tally.wide.append(100.0 * (one.diameter / (2.0 * ball.radius) - 1.0))
    known = [number for number, ball in enumerate(scene.balls) if ball.kind]
    tally.fruit += len(known)
    tally.unknown += len(scene.balls) - len(known)
    tally.missed += len(set(known) - seen)


def measure(scenes: int, first: int) -> Tally:
    """Look at scenes with a calibrated camera."""
    calibration = calibrated()
    detector = ColourDetector(KINDS, TABLE, BACKGROUND)
    tally = Tally()
    detector.detect(take(random_scene(first), CAMERA, first), calibration)
    shown = Console(stderr=True)
    for seed in track(range(first, first + scenes), "scenes", console=shown, disable=not shown.is_terminal):
        scene = random_scene(seed)
        picture = take(scene, CAMERA, seed)
        wall, processor = time.perf_counter(), time.process_time()
        found = detector.detect(picture, calibration)
        tally.wall.append(time.perf_counter() - wall)
        tally.processor.append(time.process_time() - processor)
        compare(scene, found, tally)
    return tally


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--scenes", type=int, default=200)
    asked.add_argument("--seed", type=int, default=0)
    options = asked.parse_args()
    tally = measure(options.scenes, options.seed)
    off, wide = np.array(tally.off), np.abs(tally.wide)
    table = Table("", "measured", title=f"{options.scenes} scenes, {CAMERA.size[0]} x {CAMERA.size[1]} px")
    rows = {
        "fruit": f"{tally.fruit}",
        "seen surely, unsurely, not": f"{len(off)}, {tally.unsure}, {tally.missed}",
        "false picks": f"{tally.false}",
        "of unknown kind, reported as such": f"{tally.unknown_reported} of {tally.unknown}",
        "position: median, 95th percentile, worst": "{:.2f}, {:.2f}, {:.2f} mm".format(
            *np.quantile(off, (0.5, 0.95, 1))
        ),
        "diameter: median, 95th percentile, worst": "{:.2f}, {:.2f}, {:.2f} %".format(
            *np.quantile(wide, (0.5, 0.95, 1))
        ),
        "a picture: median of wall clock, of processor": f"{1e3 * np.median(tally.wall):.1f}, "
        f"{1e3 * np.median(tally.processor):.1f} ms",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    Console().print(table)


if __name__ == "__main__":
    main()
