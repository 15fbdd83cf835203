"""What a camera is calibrated with: a ChArUco board or a checkerboard, and the markers fixed beside the arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from layflat.cell.extras import opencv, points
from layflat.cell.geometry import placed
from layflat.cell.markers import charuco, dictionary
from layflat.errors import CameraError

Array: TypeAlias = NDArray[Any]
"""Numbers, float64 unless they are pixels' values, or truths."""
Seen: TypeAlias = tuple[Array, Array]
"""Points in the frame of a board or the base (N, 3), m, and where they are in a picture (N, 2), px."""

DICTIONARY = "DICT_4X4_50"
"""The markers' dictionary; the base and the board may share it if they don't share numbers."""


@dataclass(frozen=True)
class CharucoBoard:
    """A checkerboard with ArUco markers in its white squares; may be seen in part.

    Attributes:
        columns, rows: number of squares.
        square, marker: their sides, m.
        dictionary: OpenCV's name of the markers' dictionary.
        first_id: number of its first marker; the others follow.
    """

    columns: int
    rows: int
    square: float
    marker: float
    dictionary: str = DICTIONARY
    first_id: int = 0

    def seen(self, grey: NDArray[np.uint8]) -> Seen | None:
        """Return its corners in a grey picture; None where there are too few."""
        board = charuco(self)
        corners, numbers, _, _ = opencv().aruco.CharucoDetector(board).detectBoard(grey)
        if numbers is None or len(numbers) < 6:
            return None
        known = np.asarray(board.getChessboardCorners(), dtype=np.float64)[np.ravel(numbers)]
        return known, np.asarray(points(corners), dtype=np.float64)


@dataclass(frozen=True)
class Checkerboard:
    """A checkerboard without markers; must be seen whole.

    Attributes:
        columns, rows: number of squares; one odd, one even, so that it has a beginning.
        square: side, m.
    """

    columns: int
    rows: int
    square: float

    def seen(self, grey: NDArray[np.uint8]) -> Seen | None:
        """Return its inner corners in a grey picture; None where it is not seen whole."""
        cv2 = opencv()
        inner = (self.columns - 1, self.rows - 1)
        found, corners = cv2.findChessboardCornersSB(grey, inner, flags=cv2.CALIB_CB_ACCURACY)
        if not found:
            return None
        across, down = np.meshgrid(np.arange(inner[0]), np.arange(inner[1]))
        known = np.column_stack([across.ravel(), down.ravel(), np.zeros(across.size)]) * self.square
        return known, np.asarray(points(corners), dtype=np.float64)


Board: TypeAlias = CharucoBoard | Checkerboard


@dataclass(frozen=True)
class Marker:
    """An ArUco marker that lies flat at a known place in the base frame.

    Attributes:
        number: its number in the dictionary.
        x, y: its middle, m.
        side: its length, m.
        yaw: how far its upper edge is turned from the base's x axis about z, rad.
        z: its height, m.
    """

    number: int
    x: float
    y: float
    side: float
    yaw: float = 0.0
    z: float = 0.0

    @property
    def corners(self) -> Array:
        """Its corners in the base frame, from the upper left one clockwise as seen from above, (4, 3), m."""
        half = np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]) * self.side / 2.0
        return on_base(half, self.x, self.y, self.yaw, self.z)


@dataclass(frozen=True)
class BaseMarkers:
    """The markers fixed in the base frame. One is enough for a pose; several that stand far apart make it exact."""

    markers: tuple[Marker, ...]
    dictionary: str = DICTIONARY

    def __post_init__(self) -> None:
        """Check that markers have numbers of their own.

        Raises:
            CameraError: there are none, or two with one number.
        """
        numbers = [marker.number for marker in self.markers]
        if not numbers or len(set(numbers)) < len(numbers):
            right = "give at least one, each with its own number"
            raise CameraError(f"numbers {numbers}", where="base markers", right=right)

    @property
    def description(self) -> str:
        """What to look for, in words."""
        return ", ".join(str(marker.number) for marker in self.markers)

    def seen(self, grey: NDArray[np.uint8]) -> Seen | None:
        """Return the corners of those in a grey picture; a number that is read twice is left out."""
        cv2 = opencv()
        parameters, last = cv2.aruco.DetectorParameters(), max(marker.number for marker in self.markers)
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        parameters.errorCorrectionRate = 0.0  # a tray with fruit in it may be a marker but for a bit
        detector = cv2.aruco.ArucoDetector(dictionary(self.dictionary, last), parameters)
        corners, numbers, _ = detector.detectMarkers(grey)
        read = [int(number) for number in np.ravel(numbers)] if numbers is not None else []
        known = {marker.number: marker for marker in self.markers if read.count(marker.number) == 1}
        found = [
            (known[number].corners, np.asarray(points(corner), dtype=np.float64))
            for number, corner in zip(read, corners, strict=True)
            if number in known
        ]
        if not found:
            return None
        places, pixels = zip(*found, strict=True)
        return np.concatenate(places), np.concatenate(pixels)


@dataclass(frozen=True)
class BaseBoard:
    """A ChArUco board fixed flat in the base frame, in place of single markers.

    Attributes:
        board: what it looks like.
        x: its middle, m.
        y: its middle, m.
        yaw: how far its upper edge is turned from the base's x axis about z, rad.
        z: its height, m.
    """

    board: CharucoBoard
    x: float
    y: float
    yaw: float = 0.0
    z: float = 0.0

    @property
    def description(self) -> str:
        """What to look for, in words."""
        return f"board of {self.board.columns} x {self.board.rows}, from number {self.board.first_id}"

    def seen(self, grey: NDArray[np.uint8]) -> Seen | None:
        """Return its corners in a grey picture."""
        found = self.board.seen(grey)
        if found is None:
            return None
        known, pixels = found
        size = np.array([self.board.columns, self.board.rows]) * self.board.square
        return on_base((known[:, :2] - size / 2.0) * [1.0, -1.0], self.x, self.y, self.yaw, self.z), pixels


Base: TypeAlias = BaseMarkers | BaseBoard
"""What is fixed in the base frame for the camera to see."""


def on_base(flat: Array, x: float, y: float, yaw: float, z: float) -> Array:
    """Return points of something flat (N, 2), m, its y upwards, in the base frame (N, 3)."""
    return np.column_stack([placed((x, y), yaw, flat), np.full(len(flat), z)])
