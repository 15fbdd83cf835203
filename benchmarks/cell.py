"""The packing cell: a timestep of its scene with pneumatic joints, a picture, and what vision makes of it."""

from __future__ import annotations

from benchmarks.timing import ROUNDS, median_seconds
from layflat.bridge import MujocoPlant
from layflat.cell import load
from layflat.cell.kinds import make_detector
from layflat.cell.perception import calibrate_scene
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.errors import NoDrawingError

STEPS = 1000
MEANING = {
    "cell_us_per_step": "the packing cell with pneumatic joints, per timestep of 1 ms",
    "cell_joints_ratio": "the same over its time without them",
    "cell_detection_ms": "vision on a picture of 1280 x 960 px with a tray of fruit",
    "cell_detections_per_second": "likewise; aim 25",
    "cell_overview_ms": "drawing a film's frame of 720 x 540 px",
}


def measure(rounds: int = ROUNDS) -> dict[str, float]:
    """Figures by name; those of pictures only where they can be drawn."""
    scene = Scene(load("packing"), 1)
    plant = MujocoPlant(scene.cell.machine, scene.model, scene.data)

    def with_joints() -> None:
        scene.step(STEPS, plant.step)

    step, alone = median_seconds(with_joints, 5) / STEPS, median_seconds(lambda: scene.step(STEPS), 5) / STEPS
    found = {"cell_us_per_step": 1e6 * step, "cell_joints_ratio": step / alone}
    try:
        camera = SimulatedCamera(scene)
    except NoDrawingError:
        return found
    with camera:
        calibration, detector = calibrate_scene(scene, camera), make_detector(scene.cell)
        picture = camera.picture()
        seen = median_seconds(lambda: detector.detect(picture, calibration), rounds)
        overview = median_seconds(lambda: camera.picture("overview"), rounds)
    return found | {
        "cell_detection_ms": 1e3 * seen,
        "cell_detections_per_second": 1.0 / seen,
        "cell_overview_ms": 1e3 * overview,
    }
