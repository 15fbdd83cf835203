"""Interface of detectors: kinds of produce, detections, and their drawing on a picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from layflat.arrays import Array, Picture
from layflat.cell.extras import opencv
from layflat.errors import InputError

Span: TypeAlias = tuple[float, float]
SURE_CONFIDENCE = 0.7  # from which a detection is complete and clear enough to be picked
DARK_COLOUR, BRIGHT_COLOUR = (0, 0, 0), (255, 255, 255)
BRIGHT_GROUND = 160.0  # mean level of the background from which a text is dark, of 255
GROUND_RADIUS = 16  # of the background of a text, px
SUBPIXEL_BITS = 3  # of coordinates of outlines: an eighth of a pixel


@dataclass(frozen=True)
class Colour:
    """Region of colours in HSV under the table's reference light."""

    hue: Span = (0.0, 360.0)  # from, to, degree; from 340 to 20 goes through 0
    saturation: Span = (0.0, 1.0)
    value: Span = (0.0, 1.0)


@dataclass(frozen=True)
class ProduceKind:
    """Kind of produce for a detector: round, within limits of size and colour; InputError where they are wrong."""

    name: str
    colours: tuple[Colour, ...]  # from shaded to lit, and in reflections
    diameter: Span  # least and most, m
    height_ratio: float = 1.0  # height of the middle over the table to half the diameter: 1 for a ball
    flattening: float = 1.0  # height to width of the part visible from above, upright: 1 for a ball
    roundness: float = 0.05  # greatest deviation of its outline from a circle, fraction of its radius

    def __post_init__(self) -> None:
        """Raise InputError unless 0 < least < greatest diameter, and both ratios of height are above 0."""
        if not 0.0 < self.diameter[0] < self.diameter[1]:
            right = "give the least, then the greatest, both over 0 m"
            raise InputError(f"has the diameters {self.diameter}", where=self.name, right=right)
        if self.height_ratio <= 0.0 or self.flattening <= 0.0:
            what = f"has the height_ratio {self.height_ratio:g} and the flattening {self.flattening:g}"
            raise InputError(what, where=self.name, right="give both over 0")


@dataclass(frozen=True, eq=False)
class Detection:
    """Detection of one thing on the table."""

    kind: str | None  # of produce; None for a round thing of similar size but of no known kind
    position: tuple[float, float, float]  # of its middle in the base frame, m
    diameter: float  # m
    colour: tuple[float, float, float]  # mean, RGB of 255, under the table's reference light
    confidence: float  # 0 to 1; from `SURE_CONFIDENCE` on it may be picked
    outline: Array  # complete outline, also of its hidden parts, (N, 2) px


def draw_detections(picture: Picture, detections: Sequence[Detection]) -> Picture:
    """Return a copy of a picture with the outline, kind, diameter in mm and confidence of each detection.

    Outlines below `SURE_CONFIDENCE` are dashed; an unknown kind is a question mark.
    """
    drawn = picture.copy()
    for detection in detections:
        _draw_outline(drawn, detection)
    for detection in detections:
        lines = detection.kind or "?", f"{detection.diameter * 1e3:.0f} mm", f"{detection.confidence:.2f}"
        _draw_text(drawn, lines, detection.outline.mean(axis=0))
    return drawn


def _draw_outline(drawn: Any, detection: Detection) -> None:
    """Draw the outline of a detection on a picture, dashed if its confidence is below `SURE_CONFIDENCE`."""
    cv2 = opencv()
    whole = np.round(detection.outline * 2**SUBPIXEL_BITS).astype(np.int32)
    closed = np.vstack([whole, whole[:1]])
    step = len(closed) if detection.confidence >= SURE_CONFIDENCE else 4
    dashes = [closed[start : start + (step if step > 4 else 3)] for start in range(0, len(closed) - 1, step)]
    for colour, thick in ((DARK_COLOUR, 3), (BRIGHT_COLOUR, 1)):
        cv2.polylines(drawn, dashes, False, colour, thick, cv2.LINE_AA, SUBPIXEL_BITS)


def _draw_text(drawn: Any, lines: Sequence[str], middle: Array) -> None:
    """Draw lines of text around a point (px), dark on a bright background or vice versa, with a rim for contrast."""
    cv2 = opencv()
    font, size = cv2.FONT_HERSHEY_SIMPLEX, 0.4
    across, down = (max(round(value), 0) for value in middle)
    ground = drawn[
        max(down - GROUND_RADIUS, 0) : down + GROUND_RADIUS, max(across - GROUND_RADIUS, 0) : across + GROUND_RADIUS
    ]
    bright = ground.size and float(ground.mean()) > BRIGHT_GROUND
    ink, rim = (DARK_COLOUR, BRIGHT_COLOUR) if bright else (BRIGHT_COLOUR, DARK_COLOUR)
    y = middle[1] - 6.5 * (len(lines) - 1)
    for line in lines:
        (wide, high), _ = cv2.getTextSize(line, font, size, 1)
        x, base = round(middle[0] - wide / 2), round(y + high / 2)
        for right, down in ((-1, 0), (1, 0), (0, -1), (0, 1)):  # thicker letters would be wider ones
            cv2.putText(drawn, line, (x + right, base + down), font, size, rim, 1, cv2.LINE_AA)
        cv2.putText(drawn, line, (x, base), font, size, ink, 1, cv2.LINE_AA)
        y += 13.0
