"""Boards and markers: the same picture for the scene's texture and for OpenCV's detector."""

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
    markers = np.arange(board.first_id, board.first_id + board.columns * board.rows // 2)
    words = _words(board.dictionary, int(markers[-1]), "board.first_id")
    return opencv().aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, words, markers)


def picture(board: Board) -> NDArray[np.uint8]:
    """The board, (H, W) grey levels, with no margin."""
    drawn: NDArray[np.uint8] = charuco(board).generateImage((PIXELS * board.columns, PIXELS * board.rows))
    return drawn


def marker_picture(dictionary: str, number: int) -> NDArray[np.uint8]:
    """A single marker, (H, H) grey levels, with no margin.

    Raises:
        CellError: as `charuco`.
    """
    words = _words(dictionary, number, "base_markers.number")
    modules = words.markerSize + 2
    drawn: NDArray[np.uint8] = opencv().aruco.generateImageMarker(words, number, PIXELS * modules)
    return drawn


def _words(name: str, last: int, where: str) -> Any:
    """A dictionary of OpenCV that has a marker of the number `last`."""
    cv2 = opencv()
    code = getattr(cv2.aruco, name, None)
    if not name.startswith("DICT_") or code is None:
        raise CellError(
            f"{name!r} is no dictionary of OpenCV", where="dictionary", right="give one such as DICT_4X4_50"
        )
    words = cv2.aruco.getPredefinedDictionary(code)
    if last >= len(words.bytesList):
        raise CellError(f"{name} has only {len(words.bytesList)} markers", where=where, right="give fewer")
    return words
