"""Access to MuJoCo and OpenCV, imported when they are needed; ArUco markers and ChArUco boards.

Raises MissingExtraError where a library of the extra `cell` is not installed.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from layflat import extras
from layflat.arrays import Picture
from layflat.bridge.arm import import_mujoco
from layflat.errors import CameraError

SQUARE_PIXELS = 48  # side of a square in a drawn picture, px
Array: TypeAlias = NDArray[Any]  # float64, except pixel values and booleans
PointPairs: TypeAlias = tuple[Array, Array]
"""Points in the frame of a board or the base (N, 3), m, and where they are in a picture (N, 2), px."""
DICTIONARY = "DICT_4X4_50"  # the markers' dictionary; the base and the board may share it if they don't share numbers


def mujoco() -> Any:
    """Return the package `mujoco`."""
    return import_mujoco()


def opencv() -> Any:
    """Return the package `cv2`."""
    return extras.import_extra("cell", "cv2")


@contextmanager
def single_thread() -> Iterator[None]:
    """Restrict OpenCV to one thread in this block, so that sums have one order and reproducible last digits."""
    cv2 = opencv()
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def as_rows(opencv_points: Any, width: int = 2) -> Any:
    """Return points of OpenCV, (N, 1, width) before version 5 and (N, width) since, as rows (N, width)."""
    return opencv_points.reshape(-1, width)


NO_CONTACT = {"contype": 0, "conaffinity": 0}  # of geoms that are drawn and touch nothing


Geom = Literal["box", "cylinder", "capsule", "ellipsoid", "mesh"]


def add_geom(body: Any, kind: Geom, name: str, **others: Any) -> None:
    """Add a geom to a body of an MjSpec.

    Args:
        body: MjsBody.
        kind: name of the geom's type.
        name: name of the geom.
        **others: arguments of `add_geom` of MuJoCo, lengths in m; `size` may be shorter than its three.
    """
    if "size" in others:
        others["size"] = [*others["size"], 0.0, 0.0][:3]
    body.add_geom(name=name, type=getattr(mujoco().mjtGeom, f"mjGEOM_{kind.upper()}"), **others)


@dataclass(frozen=True)
class CharucoBoard:
    """Checkerboard with ArUco markers in its white squares, which may be partly out of view."""

    columns: int  # of squares
    rows: int
    square: float  # side, m
    marker: float  # side, m
    dictionary: str = DICTIONARY  # OpenCV's name of it
    first_id: int = 0  # number of its first marker; the others follow

    def detect(self, grey: Picture) -> PointPairs | None:
        """Return the board's corners and their pixels in a grey picture; None where fewer than 6 are detected."""
        board = make_charuco_board(self)
        corners, numbers, _, _ = opencv().aruco.CharucoDetector(board).detectBoard(grey)
        if numbers is None or len(numbers) < 6:
            return None
        board_points = np.asarray(board.getChessboardCorners(), dtype=np.float64)[np.ravel(numbers)]
        return board_points, np.asarray(as_rows(corners), dtype=np.float64)


@lru_cache
def marker_dictionary(name: str, last: int) -> Any:
    """Return a predefined dictionary of OpenCV; raise CameraError unless it exists and has a marker number `last`."""
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


def make_charuco_board(board: CharucoBoard) -> Any:
    """Return a board as `cv2.aruco.CharucoBoard`; its frame begins at the first corner, x right, y down.

    Raise CameraError if the dictionary has too few markers.
    """
    markers = np.arange(board.first_id, board.first_id + board.columns * board.rows // 2)
    words = marker_dictionary(board.dictionary, int(markers[-1]))
    return opencv().aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, words, markers)


def board_picture(board: CharucoBoard) -> Picture:
    """Return the grey picture of a board, without a margin."""
    drawn: Picture = make_charuco_board(board).generateImage(
        (SQUARE_PIXELS * board.columns, SQUARE_PIXELS * board.rows)
    )
    return drawn


def marker_picture(name: str, number: int) -> Picture:
    """Return the grey picture of a marker of a dictionary, without a margin."""
    words = marker_dictionary(name, number)
    drawn: Picture = opencv().aruco.generateImageMarker(words, number, SQUARE_PIXELS * (words.markerSize + 2))
    return drawn
