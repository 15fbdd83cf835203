"""Seeing: a camera's calibration, and produce in its pictures. It is given pictures only, never a scene's state."""

from layflat.cell.vision.boards import BaseBoard, BaseMarkers, CharucoBoard, Checkerboard, Marker
from layflat.cell.vision.calibrate import calibrate, self_check
from layflat.cell.vision.calibration import Calibration, load_calibration
from layflat.cell.vision.colour import ColourDetector
from layflat.cell.vision.detection import SURE, Colour, Detection, Kind, draw
from layflat.cell.vision.onnx import OnnxDetector
from layflat.cell.vision.prepare import check_picture

__all__ = [
    "SURE", "BaseBoard", "BaseMarkers", "Calibration", "CharucoBoard", "Checkerboard", "Colour", "ColourDetector",
    "Detection", "Kind", "Marker", "OnnxDetector", "calibrate", "check_picture", "draw", "load_calibration",
    "self_check",
]  # fmt: skip
