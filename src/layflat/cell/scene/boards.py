"""ChArUco boards: the same picture for the scene's texture and for OpenCV's detector."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.cell.extras import opencv
from layflat.cell.file.seen import Board
from layflat.errors import CellError

PIXELS = 48
"""Of a square's side in the texture."""


def charuco(board: Board) -> Any:
    """The board as `cv2.aruco.CharucoBoard`: its corners count from its first, x right and y down in its picture.

    Raises:
        CellError: OpenCV has no such dictionary, or it has too few markers.
    """
    cv2 = opencv()
    code = getattr(cv2.aruco, board.dictionary, None)
    if not board.dictionary.startswith("DICT_") or code is None:
        raise CellError(
            f"{board.dictionary!r} is no dictionary of OpenCV", where="dictionary", right="give one such as DICT_4X4_50"
        )
    dictionary = cv2.aruco.getPredefinedDictionary(code)
    markers = np.arange(board.first_id, board.first_id + board.columns * board.rows // 2)
    if markers[-1] >= len(dictionary.bytesList):
        raise CellError(
            f"{board.dictionary} has only {len(dictionary.bytesList)} markers", where="first_id", right="give fewer"
        )
    return cv2.aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, dictionary, markers)


def picture(board: Board) -> NDArray[np.uint8]:
    """The board, (H, W) grey levels, with no margin."""
    drawn: NDArray[np.uint8] = charuco(board).generateImage((PIXELS * board.columns, PIXELS * board.rows))
    return drawn
