"""A detector of round produce by colour."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import opencv
from layflat.cell.vision import edges, regions
from layflat.cell.vision.boards import Array
from layflat.cell.vision.calibration import Calibration
from layflat.cell.vision.detection import Colour, Detection, Kind
from layflat.cell.vision.measure import COMPLETE, detections, inside, measure, relief
from layflat.cell.vision.prepare import check_picture, evenly_lit
from layflat.errors import InputError

SLACK = 0.08  # how far a diameter may be out of its kind's limits, share
FLAT = 0.03  # by how much a flat thing (label, lid) may get darker outwards; fruit not overexposed: 0.041 or more
FEWEST_SEEN = 0.35  # share of an outline that must be seen for a thing to be detected at all
OWN = 0.7  # share of a thing that must have its kind's colour


class _Guesses(NamedTuple):
    """Things as first seen."""

    kind: Kind  # that they may be of
    discs: Array  # rows of middle and depth, px of the halved picture
    mask: Any  # that they are in


class ColourDetector:
    """Finds round produce of known colours on a table, in a tray or in a container of other colours.

    Args:
        kinds: of produce, no colour in two of them; InputError if there are none, or two of one name.
        table: the table's colour in the reference light, RGB of 255.
        background: colours of table, trays and containers; what has none of these and is of no kind is unknown.
            Without them nothing unknown is returned.
        plane: height of what the produce rests on, m: a tray's floor.
    """

    def __init__(
        self, kinds: Sequence[Kind], table: tuple[float, float, float], background: Sequence[Colour] = (),
        plane: float = 0.0,
    ) -> None:  # fmt: skip
        names = [kind.name for kind in kinds]
        if not names or len(set(names)) < len(names):
            raise InputError(f"kinds {names}", where="detector", right="needs kinds, each with its own name")
        self.kinds, self.table, self.background, self.plane = tuple(kinds), table, tuple(background), plane
        least, most = min(kind.diameter[0] for kind in kinds), max(kind.diameter[1] for kind in kinds)
        self._unknown = Kind("unknown", (), (0.8 * least, 1.2 * most), roundness=max(kind.roundness for kind in kinds))

    def find(self, picture: Picture, calibration: Calibration) -> list[Detection]:
        """Return what lies on the table, surest first, in a picture (H, W, 3), RGB, of a calibrated camera.

        What is flat, not round or of another size is left out. Raises PictureError if the picture can't be used.
        """
        half = check_picture(picture, calibration.picture_px)
        even = evenly_lit(half, self.table)
        scale = calibration.pixels_per_metre(self.plane) / 2.0
        guesses = self._guesses(opencv().cvtColor(even, opencv().COLOR_RGB2HSV_FULL), scale)
        if not guesses:
            return []
        kinds = [guess.kind for guess in guesses for _ in guess.discs]
        rough = [_rough(guess, scale) for guess in guesses]
        places, usable = (np.concatenate(parts) for parts in zip(*rough, strict=True))
        measured = measure(picture, even, calibration, places, usable, kinds, self.plane)
        mine = _own(guesses, measured.outlines)
        own = mine.mean(axis=(1, 2))
        sure = np.clip(measured.seen / COMPLETE, 0.0, 1.0) * np.clip(own / 0.95, 0.0, 1.0)
        least, most = np.array([kind.diameter for kind in kinds]).T / 2.0
        fits = (measured.radii >= (1.0 - SLACK) * least) & (measured.radii <= (1.0 + SLACK) * most)
        good = fits & (measured.seen >= FEWEST_SEEN) & (own >= OWN)
        good &= relief(even, measured.outlines, mine) >= FLAT
        names = [None if kind is self._unknown else kind.name for kind in kinds]
        return detections(names, measured, sure, good)

    def _guesses(self, hsv: Any, scale: float) -> list[_Guesses]:
        """Return where each kind's colour, and at last none, is as wide as that kind may be."""
        cv2 = opencv()
        background = regions.in_colours(hsv, self.background)
        taken = background.copy()
        guesses = []
        for kind in (*self.kinds, self._unknown) if self.background else self.kinds:
            if kind is self._unknown:
                mask = cv2.bitwise_not(cv2.dilate(taken, np.ones((5, 5), np.uint8)))
            else:
                mask = regions.in_colours(hsv, kind.colours)
            least = kind.diameter[0] / 2.0 * scale
            whole = regions.filled(mask, background, np.pi * least**2)
            taken |= whole
            guesses.append(_Guesses(kind, regions.discs(whole, least), whole))
        return [guess for guess in guesses if len(guess.discs)]


def _rough(guess: _Guesses, scale: float) -> tuple[Array, Array]:
    """Return edges of a mask around its discs, px of the whole picture, and which of them are edges."""
    depth = guess.discs[:, 2]
    most = np.maximum(0.6 * guess.kind.diameter[1] * scale, 1.3 * depth)
    places, usable = edges.edges_of_mask(guess.mask, guess.discs[:, :2], 0.4 * depth, most)
    return 2.0 * places + 0.5, usable


def _own(guesses: Sequence[_Guesses], outlines: Array) -> Array:
    """Return where within outlines each thing has its kind's colour, 0 to 1 at each place of `inside`."""
    parts = np.split(outlines, np.cumsum([len(guess.discs) for guess in guesses])[:-1])
    shares = [edges.sampled(guess.mask, inside(part)) / 255.0 for guess, part in zip(guesses, parts, strict=True)]
    return np.concatenate(shares)
