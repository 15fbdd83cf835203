"""What a detector returns, and what it must know about the kinds of produce."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from layflat.cell.vision.calibration import Calibration
from layflat.errors import InputError

Span: TypeAlias = tuple[float, float]

SURE = 0.7  # confidence from which a detection is whole and clear enough to be picked


@dataclass(frozen=True)
class Colour:
    """A region of colours in HSV, lit as the table's reference is."""

    hue: Span = (0.0, 360.0)  # from, to, degree; from 340 to 20 goes through 0
    saturation: Span = (0.0, 1.0)
    value: Span = (0.0, 1.0)


@dataclass(frozen=True)
class Kind:
    """A kind of produce, as a detector knows it: round, within limits of size and colour.

    Raises:
        InputError: the limits of its diameter are not in order, or it is flat.
    """

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
    outline: NDArray[np.float64]  # what its outline would be if it were all seen, (N, 2) px


class Detector(Protocol):
    """Detects produce in a picture: by colour, or learned."""

    def find(self, picture: NDArray[np.uint8], calibration: Calibration) -> list[Detection]:
        """Return what lies on the table, surest first, from a picture (H, W, 3), RGB, of a calibrated camera.

        Raises:
            PictureError: the picture can't be used.
        """
