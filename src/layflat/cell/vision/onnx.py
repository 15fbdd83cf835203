"""Learned detector from an ONNX file, run by OpenCV: the network detects and classifies, geometry measures.

The network takes one picture, float32 (1, 3, rows, columns), RGB of 1, and gives boxes, (1, N, 6): left, upper, right,
lower (px of its input), score and the kind's number, as networks of the YOLO family export them with their boxes sorted
out. The ellipse in a box is where the outline is first sought.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import Array, opencv
from layflat.cell.geometry import unit_circle
from layflat.cell.vision import edges
from layflat.cell.vision.calibration import Calibration
from layflat.cell.vision.detection import Detection, ProduceKind
from layflat.cell.vision.measure import COMPLETE_FRACTION, measure_things, select_detections
from layflat.cell.vision.prepare import check_picture, normalize_light
from layflat.errors import InputError

MIN_SCORE = 0.25  # of a box, below which it is ignored
PADDING_GREY = 114  # level around a picture whose shape is not the network's, of 255


class OnnxDetector:
    """Detector of produce by a network from an ONNX file; InputError where OpenCV can't run it.

    The kinds are in the order of the network's numbers, `table` and `plane` as of a `ColourDetector`, and `size` is
    rows and columns of the network's input.
    """

    def __init__(
        self, path: Path, kinds: Sequence[ProduceKind], table: tuple[float, float, float],
        size: tuple[int, int] = (640, 640), plane: float = 0.0,
    ) -> None:  # fmt: skip
        """Load the network; raise InputError if the file is missing, or OpenCV can't read it."""
        cv2 = opencv()
        self.path, self.kinds, self.table, self.size, self.plane = path, tuple(kinds), table, size, plane
        if not path.is_file():
            raise InputError("no such file", where=str(path), right="give the path of an ONNX file")
        try:
            self._network = cv2.dnn.readNetFromONNX(str(path))
        except cv2.error:
            right = "export it as ONNX with operators that OpenCV has"
            raise InputError("is not a network that OpenCV runs", where=str(path), right=right) from None

    def detect(self, picture: Picture, calibration: Calibration) -> list[Detection]:
        """Return the network's detections, measured on the table, by confidence; a number beyond the kinds is unknown.

        Raises PictureError as any detector, and InputError where the network's input or output has another shape.
        """
        half = check_picture(picture, calibration.picture_px)
        boxes = self._boxes(picture)
        if not len(boxes):
            return []
        numbers = boxes[:, 5].astype(int)
        is_known = (numbers >= 0) & (numbers < len(self.kinds))
        kinds = [self.kinds[number if good else 0] for number, good in zip(numbers, is_known, strict=True)]
        even = normalize_light(half, self.table)
        # Places on the ellipses that fill the boxes, (N, RAY_COUNT, 2).
        middle, reach = (boxes[:, :2] + boxes[:, 2:4]) / 2.0, (boxes[:, 2:4] - boxes[:, :2]) / 2.0
        outlines = middle[:, None] + reach[:, None] * unit_circle(edges.RAY_COUNT)
        usable = np.ones(outlines.shape[:2], bool)
        measured = measure_things(picture, even, calibration, outlines, usable, kinds, self.plane)
        confidence = boxes[:, 4] * np.clip(measured.edge_fractions / COMPLETE_FRACTION, 0.0, 1.0)
        names = [kind.name if good else None for kind, good in zip(kinds, is_known, strict=True)]
        return select_detections(names, measured, confidence, measured.radii > 0.0)

    def _boxes(self, picture: Picture) -> Array:
        """Return the boxes with a score from `MIN_SCORE` on, in px of the picture, with score and number, (N, 6).

        Raise InputError where its input or output has another shape.
        """
        cv2 = opencv()
        rows, columns = picture.shape[:2]
        scale = min(self.size[0] / rows, self.size[1] / columns)
        small = cv2.resize(picture, (round(columns * scale), round(rows * scale)), interpolation=cv2.INTER_AREA)
        filled = np.full((*self.size, 3), PADDING_GREY, np.uint8)
        filled[: small.shape[0], : small.shape[1]] = small
        try:
            self._network.setInput(cv2.dnn.blobFromImage(filled, 1.0 / 255.0))
            output: Any = np.asarray(self._network.forward(), dtype=np.float64)
        except cv2.error:
            problem, right = f"fails on its input (1, 3, {self.size[0]}, {self.size[1]})", "give the size of its export"
            raise InputError(problem, where=str(self.path), right=right) from None
        if output.ndim != 3 or output.shape[0] != 1 or output.shape[2] != 6:
            what = f"has an output of the shape {output.shape}"
            raise InputError(what, where=str(self.path), right="export it with boxes (1, N, 6)")
        boxes = output[0][output[0][:, 4] >= MIN_SCORE]
        stretch = np.array([columns / small.shape[1], rows / small.shape[0]] * 2)
        boxes[:, :4] = boxes[:, :4] * stretch - 0.5
        return np.asarray(boxes[((boxes[:, 2:4] - boxes[:, :2]) > 1.0).all(axis=1)])
