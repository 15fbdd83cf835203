"""Vision: calibration of a camera, and detection of produce in its pictures, its only input."""

from layflat.cell.extras import CharucoBoard
from layflat.cell.vision.boards import BaseBoard, BaseMarkers, Checkerboard, Marker
from layflat.cell.vision.calibration import Calibration, calibrate, load_calibration, self_check
from layflat.cell.vision.colour import ColourDetector
from layflat.cell.vision.detection import SURE_CONFIDENCE, Colour, Detection, ProduceKind, draw_detections
from layflat.cell.vision.onnx import OnnxDetector
from layflat.cell.vision.prepare import check_picture

__all__ = [
    "SURE_CONFIDENCE",
    "BaseBoard",
    "BaseMarkers",
    "Calibration",
    "CharucoBoard",
    "Checkerboard",
    "Colour",
    "ColourDetector",
    "Detection",
    "Marker",
    "OnnxDetector",
    "ProduceKind",
    "calibrate",
    "check_picture",
    "draw_detections",
    "load_calibration",
    "self_check",
]  # fmt: skip
