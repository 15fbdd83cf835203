"""Whether a picture can be used at all, and what it would be in even, white light."""

from typing import Any

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import opencv
from layflat.errors import PictureError

LEAST_LEVEL, MOST_LEVEL = 20.0, 245.0  # mean of a picture, of 255
WIDEST_EDGE = 2.0  # standard deviation of the blur over which a picture is refused, px
OWN_WIDTH = 2.0  # width that halving, smoothing and differencing give to a sharp edge, px of the whole picture
REACH = 8  # px of the halved picture within which an edge must rise
STRONG = 25.0  # levels that an edge must rise for its blur to be measured
SKIPPED = 12  # every twelfth pixel each way is enough to estimate the light
NEAR = 0.09  # how far the table's chromaticity may be from its reference, in each of r and g of r + g + b = 1
FEWEST = 40  # of those pixels that must show the table


def check_picture(picture: Picture, size: tuple[int, int] | None = None, where: str = "picture") -> Any:
    """Return an RGB picture halved; raise PictureError if it is none or not of `size`, black, overexposed or blurred.

    The size is width and height.
    """
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8:
        raise PictureError(f"is {picture.dtype} {picture.shape}", where=where, right="needs uint8 (height, width, 3)")
    high, wide = picture.shape[:2]
    if size is not None and (wide, high) != tuple(size):
        raise PictureError(f"is {wide} x {high} px", where=where, right=f"calibrated were {size[0]} x {size[1]}")
    cv2 = opencv()
    half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    grey = cv2.cvtColor(half, cv2.COLOR_RGB2GRAY)
    level = float(cv2.mean(grey)[0])
    seen = f"mean level {level:.0f} of 255"
    if level < LEAST_LEVEL:
        raise PictureError(f"is black: {seen}", where=where, right="check light, lens cap, exposure")
    if level > MOST_LEVEL:
        raise PictureError(f"is white: {seen}", where=where, right="shorten the exposure")
    width = edge_width(grey)
    if width == np.inf:
        right = "check that the camera looks at the table, that nothing covers it, and that the lens is in focus"
        raise PictureError("has no edges: neither table nor markers are in view", where=where, right=right)
    if width > WIDEST_EDGE:
        right = f"at most {WIDEST_EDGE} px: clean or focus the lens, hold the camera still"
        raise PictureError(f"its sharpest edges are blurred by {width:.1f} px", where=where, right=right)
    return half


def edge_width(grey: Picture) -> float:
    """Return how blurred a halved grey picture is: standard deviation at its strongest edges, px of the whole one.

    An edge of height h, blurred by s, rises by h / (s sqrt(2 pi)) a pixel at most, however bright and noisy the
    picture is. The worse of both directions counts, as a picture blurred by motion is sharp across it.
    """
    cv2 = opencv()
    calm = cv2.GaussianBlur(grey, (3, 3), 0.7)
    widths = []
    for along in (0, 1):
        slope = np.abs(cv2.Sobel(calm, cv2.CV_32F, 1 - along, along, ksize=1)) / 2.0
        window = np.ones((2 * REACH + 1, 1) if along else (1, 2 * REACH + 1), np.uint8)
        rise = cv2.subtract(cv2.dilate(calm, window), cv2.erode(calm, window)).astype(np.float32)
        strong = rise > STRONG
        if np.count_nonzero(strong) < 20:
            return float("inf")
        steep = slope[strong] / rise[strong]
        width = 2.0 / (float(np.quantile(steep, 0.99)) * np.sqrt(2.0 * np.pi))
        widths.append(np.sqrt(max(width**2 - OWN_WIDTH**2, 0.0)))
    return float(max(widths))


def evenly_lit(picture: Picture, table: tuple[float, float, float]) -> Any:
    """Return a picture with each channel scaled so that the table has its reference colour everywhere.

    What the table shows of the light is smoothed by a polynomial of second degree in x and y (von Kries, a channel at
    a time); what lies on the table and shadows are left out by their distance from it. The table's colour in the
    reference light is RGB of 255. Raise PictureError if too little of the table is seen.
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
        problem = f"shows no table of colour RGB {tuple(round(level) for level in table)}"
        right = "give the table's colour in the image; check the lights, and that the camera looks at the table"
        raise PictureError(problem, where="picture", right=right)
    gains = np.log(np.array(table)) - np.log(np.maximum(thin, 1.0))
    terms, levels = basis[on_table], gains[on_table]
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
