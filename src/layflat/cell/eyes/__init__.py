"""Vision set up for a cell: what it looks for, a calibrated camera, grades of what it sees; never the scene's truth."""

from layflat.cell.eyes.calibrating import base_of, calibrate_scene
from layflat.cell.eyes.grading import fruit_of, place_of
from layflat.cell.eyes.kinds import background_of, detector_of, kinds_of

__all__ = ["background_of", "base_of", "calibrate_scene", "detector_of", "fruit_of", "kinds_of", "place_of"]
