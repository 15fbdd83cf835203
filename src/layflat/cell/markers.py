"""ArUco markers and ChArUco boards: one rule of what OpenCV can read, for the scene's textures and for detection."""

from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import opencv
from layflat.errors import CameraError

PIXELS = 48  # side of a square in a drawn picture, px


class BoardSizes(Protocol):
    """Sizes of a ChArUco board, as a cell describes it or a calibration is given it."""

    @property
    def columns(self) -> int:
        """Squares side by side."""

    @property
    def rows(self) -> int:
        """Squares one above the other."""

    @property
    def square(self) -> float:
        """Side of a square, m."""

    @property
    def marker(self) -> float:
        """Side of a marker, m."""

    @property
    def dictionary(self) -> str:
        """OpenCV's name of the markers' dictionary."""

    @property
    def first_id(self) -> int:
        """Number of its first marker; the others follow."""


@lru_cache
def dictionary(name: str, last: int) -> Any:
    """Return a predefined dictionary of OpenCV; raise CameraError unless there is one with a marker number `last`."""
    aruco = opencv().aruco
    code = getattr(aruco, name, None)
    if not name.startswith("DICT_") or code is None:
        raise CameraError(f"unknown dictionary {name!r}", where="markers", right="give one such as DICT_4X4_50")
    words = aruco.getPredefinedDictionary(code)
    if last >= len(words.bytesList):
        problem = f"{name} has only {len(words.bytesList)} markers, number {last} is needed"
        right = "give a larger dictionary, a smaller board or smaller numbers"
        raise CameraError(problem, where="markers", right=right)
    return words


def charuco(board: BoardSizes) -> Any:
    """Return a board as `cv2.aruco.CharucoBoard`: its corners count from the first, x right, y down in its picture."""
    markers = np.arange(board.first_id, board.first_id + board.columns * board.rows // 2)
    words = dictionary(board.dictionary, int(markers[-1]))
    return opencv().aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, words, markers)


def board_picture(board: BoardSizes) -> Picture:
    """Return the board without a margin, grey."""
    drawn: Picture = charuco(board).generateImage((PIXELS * board.columns, PIXELS * board.rows))
    return drawn


def marker_picture(name: str, number: int) -> Picture:
    """Return a marker of a dictionary without a margin, grey."""
    words = dictionary(name, number)
    drawn: Picture = opencv().aruco.generateImageMarker(words, number, PIXELS * (words.markerSize + 2))
    return drawn
