"""ArUco markers and ChArUco boards: one rule of what OpenCV can read, for the scene's textures and for detection."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from layflat.cell.extras import opencv
from layflat.errors import CameraError

PIXELS = 48
"""Side of a square in a drawn picture, px."""


class BoardShape(Protocol):
    """Squares, their and their markers' sides (m), and the markers: what the cell's file and vision both say."""

    @property
    def columns(self) -> int: ...  # noqa: D102
    @property
    def rows(self) -> int: ...  # noqa: D102
    @property
    def square(self) -> float: ...  # noqa: D102
    @property
    def marker(self) -> float: ...  # noqa: D102
    @property
    def dictionary(self) -> str: ...  # noqa: D102
    @property
    def first_id(self) -> int: ...  # noqa: D102


@lru_cache
def dictionary(name: str, last: int) -> Any:
    """Return a predefined dictionary of OpenCV that has a marker of the number `last`.

    Raises:
        CameraError: OpenCV has none of that name, or it has too few markers.
    """
    aruco = opencv().aruco
    code = getattr(aruco, name, None)
    if not name.startswith("DICT_") or code is None:
        raise CameraError(f"unknown dictionary {name!r}", where="markers", right="give one such as DICT_4X4_50")
    words = aruco.getPredefinedDictionary(code)
    if last >= len(words.bytesList):
        raise CameraError(
            f"{name} has only {len(words.bytesList)} markers, number {last} is needed",
            where="markers",
            right="give a larger dictionary, a smaller board or smaller numbers",
        )
    return words


def charuco(board: BoardShape) -> Any:
    """Return a board as `cv2.aruco.CharucoBoard`: its corners count from its first, x right and y down in its picture.

    Raises:
        CameraError: as `dictionary`.
    """
    markers = np.arange(board.first_id, board.first_id + board.columns * board.rows // 2)
    words = dictionary(board.dictionary, int(markers[-1]))
    return opencv().aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, words, markers)


def board_picture(board: BoardShape) -> NDArray[np.uint8]:
    """Return the board without a margin, (H, W) grey levels."""
    drawn: NDArray[np.uint8] = charuco(board).generateImage((PIXELS * board.columns, PIXELS * board.rows))
    return drawn


def marker_picture(name: str, number: int) -> NDArray[np.uint8]:
    """Return a marker of a dictionary without a margin, (H, H) grey levels.

    Raises:
        CameraError: as `dictionary`.
    """
    words = dictionary(name, number)
    side = PIXELS * (words.markerSize + 2)
    drawn: NDArray[np.uint8] = opencv().aruco.generateImageMarker(words, number, side)
    return drawn
