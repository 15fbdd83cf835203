"""Vision set up for a cell: what it detects, a calibrated camera, grades of what it sees; never the scene's truth."""

from layflat.cell.perception.calibrating import base_of, calibrate_scene
from layflat.cell.perception.kinds import detector_of
from layflat.cell.perception.observation import CameraPerception, Observation, Perception, ScenePerception, fruit_of

__all__ = [
    "CameraPerception", "Observation", "Perception", "ScenePerception", "base_of", "calibrate_scene", "detector_of",
    "fruit_of",
]  # fmt: skip
