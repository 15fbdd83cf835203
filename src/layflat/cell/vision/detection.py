"""What a detector must know about the kinds of produce, what it returns, and how that is drawn on a picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from layflat.arrays import Array, Picture
from layflat.cell.extras import opencv
from layflat.errors import InputError

Span: TypeAlias = tuple[float, float]
SURE = 0.7  # confidence from which a detection is whole and clear enough to be picked
DARK, BRIGHT = (0, 0, 0), (255, 255, 255)
BRIGHT_GROUND = 160.0  # mean level of what lies under a text from which it is written dark
NEAR = 16  # how far around a text its ground is looked at, px
SHIFT = 3  # outlines are drawn to an eighth of a pixel


@dataclass(frozen=True)
class Colour:
    """A region of colours in HSV, lit as the table's reference is."""

    hue: Span = (0.0, 360.0)  # from, to, degree; from 340 to 20 goes through 0
    saturation: Span = (0.0, 1.0)
    value: Span = (0.0, 1.0)


@dataclass(frozen=True)
class Kind:
    """A kind of produce, as a detector knows it: round, within limits of size and colour; InputError for others."""

    name: str
    colours: tuple[Colour, ...]  # from shaded to lit, and in reflections
    diameter: Span  # least and most, m
    height_ratio: float = 1.0  # height of the middle over the table by half the diameter: 1 for a ball
    flattening: float = 1.0  # height by width of what is seen from above, upright: 1 for a ball
    roundness: float = 0.05  # how far its outline may be from a circle, share of its radius

    def __post_init__(self) -> None:
        if not 0.0 < self.diameter[0] < self.diameter[1]:
            right = "needs least, then most, both over 0 m"
            raise InputError(f"diameter {self.diameter}", where=self.name, right=right)
        if self.height_ratio <= 0.0 or self.flattening <= 0.0:
            raise InputError("is flat", where=self.name, right="needs height_ratio and flattening over 0")


@dataclass(frozen=True, eq=False)
class Detection:
    """One thing on the table."""

    kind: str | None  # of produce; None for what is round and of such a size but of no known kind
    position: tuple[float, float, float]  # of its middle in the base frame, m
    diameter: float  # m
    colour: tuple[float, float, float]  # mean, RGB of 255, lit as the table's reference is
    confidence: float  # 0 to 1; from `SURE` on it is whole and clear
    outline: Array  # what its outline would be if it were all seen, (N, 2) px


def draw(picture: Picture, detections: Sequence[Detection]) -> Picture:
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


def _text(drawn: Any, lines: Sequence[str], middle: Array) -> None:
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
