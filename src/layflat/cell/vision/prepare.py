"""Preparation of pictures: check of brightness and sharpness, and normalization of the light."""

from typing import Any

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import opencv
from layflat.errors import PictureError

MIN_LEVEL, MAX_LEVEL = 20.0, 245.0  # of a picture's mean, of 255
MAX_EDGE_WIDTH = 2.0  # standard deviation of the blur, beyond which a picture is refused, px
PROCESSING_WIDTH = 2.0  # of a sharp edge after halving, smoothing and differencing, px of the whole picture
EDGE_REACH = 8  # within which an edge has its full rise, px of the halved picture
MIN_EDGE_RISE = 25.0  # levels, of an edge whose blur is measured
PIXEL_STRIDE = 12  # in both directions, in estimating the light
TABLE_TOLERANCE = 0.09  # deviation of the table's chromaticity from its reference, in each of r and g of 1
MIN_TABLE_PIXELS = 40  # of the sampled pixels that show the table


def check_picture(picture: Picture, size: tuple[int, int] | None = None, where: str = "picture") -> Any:
    """Check that a picture can be used, and return it at half the resolution.

    Args:
        picture: (H, W, 3) RGB, uint8.
        size: required width and height, px; None: any.
        where: name of the picture in errors.

    Raises:
        PictureError: it is no picture of that size, black, overexposed, without edges, or blurred by more than
            `MAX_EDGE_WIDTH`.
    """
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8:
        what = f"has the type {picture.dtype} and the shape {picture.shape}"
        raise PictureError(what, where=where, right="give uint8 (height, width, 3)")
    high, wide = picture.shape[:2]
    if size is not None and (wide, high) != tuple(size):
        raise PictureError(f"is {wide} x {high} px", where=where, right=f"give {size[0]} x {size[1]} px")
    cv2 = opencv()
    half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    grey = cv2.cvtColor(half, cv2.COLOR_RGB2GRAY)
    level = float(cv2.mean(grey)[0])
    seen = f"mean level {level:.0f} of 255"
    if level < MIN_LEVEL:
        raise PictureError(f"is black: {seen}", where=where, right="check light, lens cap, exposure")
    if level > MAX_LEVEL:
        raise PictureError(f"is white: {seen}", where=where, right="shorten the exposure")
    width = edge_width(grey)
    if width == np.inf:
        right = "check that the camera looks at the table, that nothing covers it, and that the lens is in focus"
        raise PictureError("has no edges: neither table nor markers are in view", where=where, right=right)
    if width > MAX_EDGE_WIDTH:
        right = f"at most {MAX_EDGE_WIDTH} px: clean or focus the lens, hold the camera still"
        raise PictureError(f"its sharpest edges are blurred by {width:.1f} px", where=where, right=right)
    return half


def edge_width(grey: Picture) -> float:
    """Return the blur of a halved grey picture: standard deviation at its strongest edges, px of the whole one.

    An edge of height h, blurred by s, rises by h / (s sqrt(2 pi)) a pixel at most, however bright and noisy the
    picture is. The worse of both directions counts, as a picture blurred by motion is sharp across it; infinite where
    one direction has too few edges.
    """
    cv2 = opencv()
    smooth = cv2.GaussianBlur(grey, (3, 3), 0.7)
    widths = []
    for along in (0, 1):
        slope = np.abs(cv2.Sobel(smooth, cv2.CV_32F, 1 - along, along, ksize=1)) / 2.0
        window = np.ones((2 * EDGE_REACH + 1, 1) if along else (1, 2 * EDGE_REACH + 1), np.uint8)
        rise = cv2.subtract(cv2.dilate(smooth, window), cv2.erode(smooth, window)).astype(np.float32)
        strong = rise > MIN_EDGE_RISE
        if np.count_nonzero(strong) < 20:
            return float("inf")
        steep = slope[strong] / rise[strong]
        width = 2.0 / (float(np.quantile(steep, 0.99)) * np.sqrt(2.0 * np.pi))
        widths.append(np.sqrt(max(width**2 - PROCESSING_WIDTH**2, 0.0)))
    return float(max(widths))


def normalize_light(picture: Picture, table: tuple[float, float, float]) -> Any:
    """Return a picture with each channel scaled so that the table has its reference colour everywhere.

    The light on the table is fitted by a polynomial of second degree in x and y (von Kries, a channel at a time);
    things on the table and shadows are outliers. The table's colour in the reference light is RGB of 255. Raise
    PictureError if too little of the table is visible.
    """
    cv2 = opencv()
    thin = picture[::PIXEL_STRIDE, ::PIXEL_STRIDE].astype(np.float64)
    rows, columns = thin.shape[:2]
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, columns), np.linspace(-1.0, 1.0, rows))
    basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    total = thin.sum(axis=2)
    reference = np.array(table) / np.sum(table)
    away = np.abs(thin / np.maximum(total, 1.0)[..., None] - reference).max(axis=2)
    on_table = (away < TABLE_TOLERANCE) & (total > 0.15 * np.sum(table)) & (thin.max(axis=2) < 250)
    if np.count_nonzero(on_table) < MIN_TABLE_PIXELS:
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
