"""Detector of round produce by colour."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import Array, opencv
from layflat.cell.vision import edges, regions
from layflat.cell.vision.calibration import Calibration
from layflat.cell.vision.detection import Colour, Detection, ProduceKind
from layflat.cell.vision.measure import (
    COMPLETE_FRACTION,
    inner_points,
    measure_things,
    radial_relief,
    select_detections,
)
from layflat.cell.vision.prepare import check_picture, normalize_light
from layflat.errors import InputError

DIAMETER_SLACK = 0.08  # relative tolerance of a kind's limits of the diameter
MIN_RELIEF = 0.03  # relative radial darkening: of flat things (label, lid) less, of fruit 0.041 or more
MIN_OUTLINE_FRACTION = 0.35  # visible fraction of an outline, below which a thing is not detected
MIN_COLOUR_FRACTION = 0.7  # of a thing's area with its kind's colour


class _Candidates(NamedTuple):
    """Candidates of one kind, from its colours."""

    kind: ProduceKind  # of all of them
    discs: Array  # rows of middle and depth, px of the halved picture
    mask: Any  # pixels of the kind's colours, 0 and 255


class ColourDetector:
    """Detector of round produce of known colours on a table, in a tray or in a container of other colours.

    Args:
        kinds: kinds of produce, no colour in two of them; InputError if there are none, or two of one name.
        table: the table's colour in the reference light, RGB of 255.
        background: colours of table, trays and containers; things of other colours and of no kind are unknown.
            Without them no unknown things are returned.
        plane: height of the floor on which produce lies, m.
    """

    def __init__(
        self, kinds: Sequence[ProduceKind], table: tuple[float, float, float], background: Sequence[Colour] = (),
        plane: float = 0.0,
    ) -> None:  # fmt: skip
        """Store the kinds, and a further one for unknown things, 20 % smaller to 20 % larger than all of them."""
        names = [kind.name for kind in kinds]
        if not names or len(set(names)) < len(names):
            raise InputError(f"has the kinds {names}", where="detector", right="give kinds, each with its own name")
        self.kinds, self.table, self.background, self.plane = tuple(kinds), table, tuple(background), plane
        least, most = min(kind.diameter[0] for kind in kinds), max(kind.diameter[1] for kind in kinds)
        self._unknown = ProduceKind(
            "unknown", (), (0.8 * least, 1.2 * most), roundness=max(kind.roundness for kind in kinds)
        )

    def detect(self, picture: Picture, calibration: Calibration) -> list[Detection]:
        """Return the detections in a picture (H, W, 3), RGB, of a calibrated camera, by confidence.

        Flat things, and those that are not round or of another size, are left out. Raise PictureError if the picture
        can't be used.
        """
        half = check_picture(picture, calibration.picture_px)
        even = normalize_light(half, self.table)
        scale = calibration.pixels_per_metre(self.plane) / 2.0
        guesses = self._candidates(opencv().cvtColor(even, opencv().COLOR_RGB2HSV_FULL), scale)
        if not guesses:
            return []
        kinds = [guess.kind for guess in guesses for _ in guess.discs]
        rough = [_rough_outlines(guess, scale) for guess in guesses]
        places, usable = (np.concatenate(parts) for parts in zip(*rough, strict=True))
        measured = measure_things(picture, even, calibration, places, usable, kinds, self.plane)
        mine = _sample_masks(guesses, measured.outlines)
        own = mine.mean(axis=(1, 2))
        sure = np.clip(measured.edge_fractions / COMPLETE_FRACTION, 0.0, 1.0) * np.clip(own / 0.95, 0.0, 1.0)
        least, most = np.array([kind.diameter for kind in kinds]).T / 2.0
        fits = (measured.radii >= (1.0 - DIAMETER_SLACK) * least) & (measured.radii <= (1.0 + DIAMETER_SLACK) * most)
        good = fits & (measured.edge_fractions >= MIN_OUTLINE_FRACTION) & (own >= MIN_COLOUR_FRACTION)
        good &= radial_relief(even, measured.outlines, mine) >= MIN_RELIEF
        names = [None if kind is self._unknown else kind.name for kind in kinds]
        return select_detections(names, measured, sure, good)

    def _candidates(self, hsv: Any, scale: float) -> list[_Candidates]:
        """Return candidates by each kind's colours, and at last, given a background, by the absence of all colours.

        Kinds without any are left out. `scale`: px of the halved picture a metre.
        """
        cv2 = opencv()
        background = regions.colour_mask(hsv, self.background)
        taken = background.copy()
        guesses = []
        for kind in (*self.kinds, self._unknown) if self.background else self.kinds:
            if kind is self._unknown:
                mask = cv2.bitwise_not(cv2.dilate(taken, np.ones((5, 5), np.uint8)))
            else:
                mask = regions.colour_mask(hsv, kind.colours)
            least = kind.diameter[0] / 2.0 * scale
            whole = regions.clean_mask(mask, background, np.pi * least**2)
            taken |= whole
            guesses.append(_Candidates(kind, regions.find_discs(whole, least), whole))
        return [guess for guess in guesses if len(guess.discs)]


def _rough_outlines(guess: _Candidates, scale: float) -> tuple[Array, Array]:
    """Return points on a mask's edges around its discs, px of the whole picture, and flags of true edges."""
    depth = guess.discs[:, 2]
    most = np.maximum(0.6 * guess.kind.diameter[1] * scale, 1.3 * depth)
    places, usable = edges.find_mask_edges(guess.mask, guess.discs[:, :2], 0.4 * depth, most)
    return 2.0 * places + 0.5, usable


def _sample_masks(guesses: Sequence[_Candidates], outlines: Array) -> Array:
    """Return the presence of a kind's colour within outlines, in the order of all discs: 0 to 1 by `inner_points`."""
    parts = np.split(outlines, np.cumsum([len(guess.discs) for guess in guesses])[:-1])
    shares = [
        edges.sample_picture(guess.mask, inner_points(part)) / 255.0 for guess, part in zip(guesses, parts, strict=True)
    ]
    return np.concatenate(shares)
