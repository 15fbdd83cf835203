"""Pictures as if the light were even, white and of the strength at which colours were given."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.cell.extras import opencv
from layflat.errors import PictureError

SKIPPED = 12
"""Every twelfth pixel each way is enough to estimate the light."""
NEAR = 0.09
"""How far the table's chromaticity may be from its reference, in each of r and g of r + g + b = 1."""
FEWEST = 40


def evenly_lit(picture: NDArray[np.uint8], table: tuple[float, float, float], where: str = "picture") -> Any:
    """Return a picture with each channel scaled so that the table has its reference colour everywhere.

    What the table shows of the light is smoothed by a polynomial of second degree in x and y (von Kries, a channel at
    a time); what lies on the table and shadows are left out by their distance from it.

    Args:
        picture: RGB, (H, W, 3).
        table: the table's colour in the reference light, RGB of 255.
        where: the picture's name, for the error.

    Raises:
        PictureError: too little of the table is seen.
    """
    cv2 = opencv()
    thin = picture[::SKIPPED, ::SKIPPED].astype(np.float64)
    rows, columns = thin.shape[:2]
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, columns), np.linspace(-1.0, 1.0, rows))
    basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    total = thin.sum(axis=2)
    reference = np.array(table) / np.sum(table)
    away = np.abs(thin / np.maximum(total, 1.0)[..., None] - reference).max(axis=2)
    on_table = (away < NEAR) & (total > 0.15 * np.sum(table)) & (thin.max(axis=2) < 250)
    if np.count_nonzero(on_table) < FEWEST:
        raise PictureError(
            f"shows no table of colour RGB {tuple(round(level) for level in table)}",
            where=where,
            right="give the table's colour in the image; check the lights, and that the camera looks at the table",
        )
    gains = np.log(np.array(table)) - np.log(np.maximum(thin, 1.0))
    terms = basis[on_table]
    levels = gains[on_table]
    # The table is most of what has its colour: trays of nearly that colour, markers and shadows are off its median.
    off = np.abs(levels - np.median(levels, axis=0)).max(axis=1)
    keep = off <= max(1.5 * float(np.median(off)), 0.15)
    for _ in range(4):
        square = terms[keep].T @ terms[keep] + 1e-6 * np.eye(terms.shape[1])
        fitted = np.linalg.solve(square, terms[keep].T @ levels[keep])
        off = np.abs(levels - terms @ fitted).max(axis=1)
        keep = off <= max(2.5 * float(np.median(off[keep])), 0.02)
    smooth = np.exp(basis @ fitted).astype(np.float32)
    full = cv2.resize(smooth, (picture.shape[1], picture.shape[0]), interpolation=cv2.INTER_LINEAR)
    return cv2.multiply(picture, full, dtype=cv2.CV_8U)
