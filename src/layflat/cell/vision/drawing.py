"""Detections drawn on a picture, for contact sheets: to be read in black and white too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.cell.extras import opencv
from layflat.cell.vision.detection import SURE, Detection

DARK, BRIGHT = (0, 0, 0), (255, 255, 255)
BRIGHT_GROUND = 160.0  # mean level of what lies under a text from which it is written dark
NEAR = 16  # how far around a text its ground is looked at, px
SHIFT = 3  # outlines are drawn to an eighth of a pixel


def draw(picture: NDArray[np.uint8], detections: Sequence[Detection]) -> NDArray[np.uint8]:
    """Return a copy of a picture with each detection's outline, kind, diameter in mm and confidence.

    Sure ones have a whole outline, unsure ones a dashed one; what is of no known kind has a question mark.
    """
    drawn = picture.copy()
    for detection in detections:
        _outline(drawn, detection)
    for detection in detections:
        lines = detection.kind or "?", f"{detection.diameter * 1e3:.0f} mm", f"{detection.confidence:.2f}"
        _text(drawn, lines, detection.outline.mean(axis=0))
    return drawn


def _outline(drawn: Any, detection: Detection) -> None:
    cv2 = opencv()
    whole = np.round(detection.outline * 2**SHIFT).astype(np.int32)
    closed = np.vstack([whole, whole[:1]])
    step = len(closed) if detection.confidence >= SURE else 4
    dashes = [closed[start : start + (step if step > 4 else 3)] for start in range(0, len(closed) - 1, step)]
    for colour, thick in ((DARK, 3), (BRIGHT, 1)):
        cv2.polylines(drawn, dashes, False, colour, thick, cv2.LINE_AA, SHIFT)


def _text(drawn: Any, lines: Sequence[str], middle: NDArray[np.float64]) -> None:
    """Write lines about a point (px), dark on bright ground and bright on dark ground, each with a rim of the other."""
    cv2 = opencv()
    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.4
    across, down = (max(round(value), 0) for value in middle)
    ground = drawn[max(down - NEAR, 0) : down + NEAR, max(across - NEAR, 0) : across + NEAR]
    bright = ground.size and float(ground.mean()) > BRIGHT_GROUND
    ink, rim = (DARK, BRIGHT) if bright else (BRIGHT, DARK)
    y = middle[1] - 6.5 * (len(lines) - 1)
    for line in lines:
        (wide, high), _ = cv2.getTextSize(line, font, size, 1)
        x, base = round(middle[0] - wide / 2), round(y + high / 2)
        for right, down in ((-1, 0), (1, 0), (0, -1), (0, 1)):  # thicker letters would be wider ones
            cv2.putText(drawn, line, (x + right, base + down), font, size, rim, 1, cv2.LINE_AA)
        cv2.putText(drawn, line, (x, base), font, size, ink, 1, cv2.LINE_AA)
        y += 13.0
