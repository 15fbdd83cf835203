"""A detector of round produce by colour."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.cell.vision import balls, edges, regions
from layflat.cell.vision.boards import Array
from layflat.cell.vision.calibration import Calibration
from layflat.cell.vision.detection import Colour, Detection, Kind
from layflat.cell.vision.light import evenly_lit
from layflat.cell.vision.opencv import opencv
from layflat.cell.vision.usable import check_picture
from layflat.errors import InputError

UNKNOWN = "unknown"
SLACK = 0.08
"""How far a diameter may be out of its kind's limits, share."""
FLAT = 0.03
"""Spread of light over a thing, share of its mean, under which it is flat: a label, a lid."""
FEWEST_SEEN = 0.35
"""Share of an outline that must be seen for a thing to be told at all."""
COMPLETE = 0.8
"""Share of an outline from which it is as good as whole: what touches others is never seen all around."""
OWN = 0.7
"""Share of a thing that must have its kind's colour."""
DUST = 0.6
"""Pixels of the halved picture that an outline may be off in any case."""


@dataclass(frozen=True)
class _Guesses:
    """Things as first seen: kind's number, middle and depth, px of the halved picture, and the mask they are in."""

    kind: int
    discs: Array
    mask: Any


class ColourDetector:
    """Finds round produce of known colours on a table, in a tray or in a pack of other colours.

    Args:
        kinds: of produce, no colour in two of them.
        table: the table's colour in the reference light, RGB of 255.
        background: colours of table, tray and packs; what has none of them and is of no kind is unknown.

    Raises:
        InputError: no kinds, or two of one name.
    """

    def __init__(
        self, kinds: Sequence[Kind], table: tuple[float, float, float], background: Sequence[Colour] = ()
    ) -> None:
        names = [kind.name for kind in kinds]
        if not names or len(set(names)) < len(names):
            raise InputError(f"kinds {names}", where="detector", right="needs kinds, each with its own name")
        self.kinds, self.table, self.background = tuple(kinds), table, tuple(background)
        least, most = min(kind.diameter[0] for kind in kinds), max(kind.diameter[1] for kind in kinds)
        anything = Kind(UNKNOWN, (), (0.8 * least, 1.2 * most), roundness=max(kind.roundness for kind in kinds))
        self._told = (*self.kinds, anything)

    def find(self, picture: NDArray[np.uint8], calibration: Calibration) -> list[Detection]:
        """What lies on the table, surest first.

        Raises:
            PictureError: the picture can't be used.
        """
        cv2 = opencv()
        half = check_picture(picture, calibration.picture_px)
        even = evenly_lit(half, self.table)
        hsv = cv2.cvtColor(even, cv2.COLOR_RGB2HSV_FULL)
        scale = calibration.pixels_per_metre() / 2.0
        guesses = [guess for guess in self._guesses(hsv, scale) if len(guess.discs)]
        if not guesses:
            return []
        kinds = [self._told[guess.kind] for guess in guesses for _ in guess.discs]
        roundness = np.array([kind.roundness for kind in kinds])
        middle, half_angle, seen = self._cones(picture, calibration, guesses, roundness)
        ratio = np.array([kind.height_ratio for kind in kinds])
        middles, radii = balls.place(middle, half_angle, calibration.position, 0.0, ratio)
        outlines = calibration.to_pixels(calibration.position + balls.cone_rays(middle, half_angle, edges.AROUND))
        own = self._own(guesses, outlines)
        colours, relief = self._look(even, outlines)
        return _told(kinds, middles, radii, outlines, seen.mean(axis=1), own, colours, relief)

    def _guesses(self, hsv: Any, scale: float) -> list[_Guesses]:
        cv2 = opencv()
        background = regions.in_colours(hsv, self.background)
        known = background.copy()
        guesses = []
        for number, kind in enumerate(self._told):
            if kind.name == UNKNOWN:
                mask = cv2.bitwise_not(cv2.dilate(known, np.ones((3, 3), np.uint8)))
            else:
                mask = regions.in_colours(hsv, kind.colours)
                known |= mask
            least = kind.diameter[0] / 2.0 * scale
            whole = regions.filled(mask, background, np.pi * least**2)
            guesses.append(_Guesses(number, regions.discs(whole, least), whole))
        return guesses if self.background else guesses[:-1]

    def _cones(
        self, picture: Any, calibration: Calibration, guesses: list[_Guesses], roundness: Array
    ) -> tuple[Array, Array, Array]:
        """Cones around what was guessed: by masks, then twice by the picture itself."""
        scale = calibration.pixels_per_metre()
        places, usable = [], []
        for guess in guesses:
            depth = guess.discs[:, 2]
            most = 0.6 * self._told[guess.kind].diameter[1] * scale / 2.0
            at, edge = edges.edges_of_mask(guess.mask, guess.discs[:, :2], 0.4 * depth, np.maximum(most, 1.3 * depth))
            places.append(2.0 * at + 0.5)
            usable.append(edge)
        least = 2.0 * DUST / float(calibration.matrix[0, 0])
        at, edge = np.concatenate(places), np.concatenate(usable)
        middle, half, seen = balls.fit_cones(calibration.rays(at), edge, 2.0 * roundness, 2.0 * least)
        for _ in range(2):
            rays = balls.cone_rays(middle, half, edges.AROUND)
            at, edge = edges.edges_of_picture(picture, calibration.to_pixels(calibration.position + rays))
            middle, half, seen = balls.fit_cones(calibration.rays(at), edge, roundness, least)
        return middle, half, seen

    def _own(self, guesses: list[_Guesses], outlines: Array) -> Array:
        """How much of each thing has its kind's colour."""
        shares, start = [], 0
        for guess in guesses:
            inside = _inside(outlines[start : start + len(guess.discs)])
            shares.append(edges.sampled(guess.mask, inside).mean(axis=(1, 2)) / 255.0)
            start += len(guess.discs)
        return np.concatenate(shares)

    def _look(self, even: Any, outlines: Array) -> tuple[Array, Array]:
        """Mean colours (B, 3), reflections left out, and the spread of light over each thing, share of its mean."""
        inside = _inside(outlines)
        values = edges.sampled(even, inside).reshape(len(outlines), -1, 3)
        level = values.mean(axis=2)
        dull = level <= np.sort(level, axis=1)[:, -level.shape[1] // 10, None]
        colours = (values * dull[..., None]).sum(axis=1) / dull.sum(axis=1, keepdims=True)
        at = (inside - outlines.mean(axis=1)[:, None, None]).reshape(len(outlines), -1, 2)
        at /= np.maximum(np.abs(at).max(axis=(1, 2), keepdims=True), 1e-9)
        x, y = at[..., 0], at[..., 1]
        basis = np.stack([np.ones_like(x), x, y, x * x + y * y], axis=-1)
        square = np.einsum("bpi,bpj->bij", basis, basis) + 1e-6 * np.eye(4)
        terms = np.linalg.solve(square, np.einsum("bpi,bp->bi", basis, level)[..., None])
        return colours, (basis @ terms)[..., 0].std(axis=1) / np.maximum(level.mean(axis=1), 1.0)


def _inside(outlines: Array) -> Array:
    """Places evenly spread within outlines, px of the halved picture."""
    shares = np.sqrt(np.linspace(0.04, 0.75, 8))
    middle = outlines.mean(axis=1)[:, None, None]
    return np.asarray((middle + shares[:, None] * (outlines[:, ::4, None] - middle) - 0.5) / 2.0)


def _told(
    kinds: list[Kind],
    middles: Array,
    radii: Array,
    outlines: Array,
    seen: Array,
    own: Array,
    colours: Array,
    relief: Array,
) -> list[Detection]:
    """Detections of what is round, of its kind's size and colour, and not flat; the surest of those at one place."""
    fits = np.array([k.diameter[0] * (1 - SLACK) <= 2 * r <= k.diameter[1] * (1 + SLACK) for k, r in zip(kinds, radii, strict=True)])
    known = np.array([kind.name != UNKNOWN for kind in kinds])
    sure = np.clip(seen / COMPLETE, 0.0, 1.0) * np.clip(own / 0.95, 0.0, 1.0)
    good = fits & (seen >= FEWEST_SEEN) & (own >= OWN) & ((relief >= FLAT) | ~known)
    order = np.flatnonzero(good)
    order = order[np.lexsort((-sure[order], ~known[order]))]
    kept = regions.apart(np.column_stack([middles[order, :2], radii[order], order]))[:, 3].astype(int)
    found = []
    for number in kept[np.argsort(-sure[kept], kind="stable")]:
        kind, colour = kinds[number], np.clip(colours[number], 0.0, 255.0)
        hue = 360.0 * colorsys.rgb_to_hsv(*(colour / 255.0))[0]
        found.append(
            Detection(
                kind=kind.name if known[number] else None,
                position=tuple(middles[number].tolist()),
                diameter=2.0 * float(radii[number]),
                grade=kind.grade(hue),
                hue=hue,
                colour=tuple(colour.tolist()),
                confidence=float(sure[number]),
                outline=outlines[number],
            )
        )
    return found
