"""ArUco markers and ChArUco boards: one rule of what OpenCV can read, for the scene's textures and for detection."""

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import opencv
from layflat.errors import CameraError

if TYPE_CHECKING:
    from layflat.cell.file.imaging import Board
    from layflat.cell.vision.boards import CharucoBoard

PIXELS = 48  # side of a square in a drawn picture, px


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


def charuco(board: "Board | CharucoBoard") -> Any:
    """Return a board as `cv2.aruco.CharucoBoard`: its corners count from the first, x right, y down in its picture."""
    markers = np.arange(board.first_id, board.first_id + board.columns * board.rows // 2)
    words = dictionary(board.dictionary, int(markers[-1]))
    return opencv().aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, words, markers)


def board_picture(board: "Board | CharucoBoard") -> Picture:
    """Return the board without a margin, grey."""
    drawn: Picture = charuco(board).generateImage((PIXELS * board.columns, PIXELS * board.rows))
    return drawn


def marker_picture(name: str, number: int) -> Picture:
    """Return a marker of a dictionary without a margin, grey."""
    words = dictionary(name, number)
    drawn: Picture = opencv().aruco.generateImageMarker(words, number, PIXELS * (words.markerSize + 2))
    return drawn
