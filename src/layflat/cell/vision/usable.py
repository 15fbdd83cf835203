"""Whether a picture can be used at all: of the right size, neither black nor blurred."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.cell.extras import opencv
from layflat.errors import PictureError

LEAST_LEVEL, MOST_LEVEL = 20.0, 245.0
"""Mean of a picture, of 255."""
WIDEST_EDGE = 2.0
"""Standard deviation of the blur over which a picture is refused, px."""
OWN_WIDTH = 2.0
"""Width that halving, smoothing and differencing give to a sharp edge, px of the whole picture."""
REACH = 8
"""Px of the halved picture within which an edge must rise."""
STRONG = 25.0
"""Levels that an edge must rise for its blur to be measured."""


def check_picture(picture: NDArray[np.uint8], size: tuple[int, int] | None = None, where: str = "picture") -> Any:
    """Refuse a picture that can't be used; return it halved, as all looks begin with that.

    Args:
        picture: RGB, (H, W, 3).
        size: the width and height it should have, px.
        where: its name, for the error.

    Raises:
        PictureError: it is no picture, of another size, black, overexposed or blurred.
    """
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8:
        raise PictureError(f"is {picture.dtype} {picture.shape}", where=where, right="needs uint8 (height, width, 3)")
    if size is not None and (picture.shape[1], picture.shape[0]) != tuple(size):
        raise PictureError(
            f"is {picture.shape[1]} x {picture.shape[0]} px",
            where=where,
            right=f"calibrated were {size[0]} x {size[1]}",
        )
    cv2 = opencv()
    half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    grey = cv2.cvtColor(half, cv2.COLOR_RGB2GRAY)
    level = float(cv2.mean(grey)[0])
    if level < LEAST_LEVEL:
        raise PictureError(
            f"is black: mean level {level:.0f} of 255", where=where, right="check light, lens cap, exposure"
        )
    if level > MOST_LEVEL:
        raise PictureError(f"is white: mean level {level:.0f} of 255", where=where, right="shorten the exposure")
    wide = edge_width(grey)
    if wide > WIDEST_EDGE:
        raise _blurred(wide, where)
    return half


def _blurred(wide: float, where: str) -> PictureError:
    if np.isfinite(wide):
        right = f"at most {WIDEST_EDGE} px: clean or focus the lens, hold the camera still"
        return PictureError(f"its sharpest edges are blurred by {wide:.1f} px", where=where, right=right)
    right = "check that the camera looks at the table, that nothing covers it, and that the lens is in focus"
    return PictureError("has no edges: neither table nor markers are in view", where=where, right=right)


def edge_width(grey: NDArray[np.uint8]) -> float:
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
