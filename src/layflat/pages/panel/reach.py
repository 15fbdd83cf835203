"""Where a tip may go in a level plane, to be shown and clicked."""

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.motion.inverse import Inverse

ROWS = 61  # of the grid, and its columns


def reachable(inverse: Inverse, height: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return a grid of places at a height (m) in the frame of the base, and which of them the tip comes to.

    The grid is (rows, columns, 3), m; the flags are (rows, columns). Places are only looked for near mid-stroke.
    """
    low, high = inverse.tips.min(axis=0), inverse.tips.max(axis=0)
    x, y = np.linspace(low[0], high[0], ROWS), np.linspace(low[1], high[1], ROWS)
    corners = np.stack([*np.meshgrid(x, y), np.full((ROWS, ROWS), height)], axis=-1)
    found = inverse.near(corners.reshape(-1, 3), np.zeros(inverse.joints))
    return corners, found.there.reshape(ROWS, ROWS)
