"""What a camera is calibrated with: a ChArUco board or a checkerboard, and the markers fixed beside the arm."""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Picture
from layflat.cell.extras import opencv, points
from layflat.cell.geometry import placed
from layflat.cell.markers import charuco, dictionary
from layflat.errors import CameraError

Array: TypeAlias = NDArray[Any]  # numbers, float64 unless they are pixels' values, or truths
Seen: TypeAlias = tuple[Array, Array]
"""Points in the frame of a board or the base (N, 3), m, and where they are in a picture (N, 2), px."""

DICTIONARY = "DICT_4X4_50"  # the markers' dictionary; the base and the board may share it if they don't share numbers


@dataclass(frozen=True)
class CharucoBoard:
    """A checkerboard with ArUco markers in its white squares; may be seen in part."""

    columns: int  # of squares
    rows: int
    square: float  # side, m
    marker: float  # side, m
    dictionary: str = DICTIONARY  # OpenCV's name of it
    first_id: int = 0  # number of its first marker; the others follow

    def seen(self, grey: Picture) -> Seen | None:
        """Return its corners in a grey picture; None where there are too few."""
        board = charuco(self)
        corners, numbers, _, _ = opencv().aruco.CharucoDetector(board).detectBoard(grey)
        if numbers is None or len(numbers) < 6:
            return None
        known = np.asarray(board.getChessboardCorners(), dtype=np.float64)[np.ravel(numbers)]
        return known, np.asarray(points(corners), dtype=np.float64)


@dataclass(frozen=True)
class Checkerboard:
    """A checkerboard without markers; must be seen whole."""

    columns: int  # of squares; columns or rows odd, the others even, so that it has a beginning
    rows: int
    square: float  # side, m

    def seen(self, grey: Picture) -> Seen | None:
        """Return its inner corners in a grey picture; None where it is not seen whole."""
        cv2 = opencv()
        inner = (self.columns - 1, self.rows - 1)
        found, corners = cv2.findChessboardCornersSB(grey, inner, flags=cv2.CALIB_CB_ACCURACY)
        if not found:
            return None
        across, down = np.meshgrid(np.arange(inner[0]), np.arange(inner[1]))
        known = np.column_stack([across.ravel(), down.ravel(), np.zeros(across.size)]) * self.square
        return known, np.asarray(points(corners), dtype=np.float64)


@dataclass(frozen=True)
class Marker:
    """An ArUco marker that lies flat at a known place in the base frame."""

    number: int  # in the dictionary
    x: float  # of its middle, m
    y: float
    side: float  # m
    yaw: float = 0.0  # from the base's x axis to its upper edge, about z, rad
    z: float = 0.0  # height, m

    @property
    def corners(self) -> Array:
        """Its corners in the base frame, from the upper left one clockwise as seen from above, (4, 3), m."""
        half = np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]) * self.side / 2.0
        return _on_base(half, self)


@dataclass(frozen=True)
class BaseMarkers:
    """The markers fixed in the base frame, each with its own number; several that are far apart give an exact pose."""

    markers: tuple[Marker, ...]
    dictionary: str = DICTIONARY

    def __post_init__(self) -> None:
        numbers = [marker.number for marker in self.markers]
        if not numbers or len(set(numbers)) < len(numbers):
            right = "give at least one, each with its own number"
            raise CameraError(f"numbers {numbers}", where="base markers", right=right)

    @property
    def description(self) -> str:
        """What to look for, in words."""
        return ", ".join(str(marker.number) for marker in self.markers)

    def seen(self, grey: Picture) -> Seen | None:
        """Return the corners of those in a grey picture; a number that is read twice is left out."""
        cv2 = opencv()
        parameters, last = cv2.aruco.DetectorParameters(), max(marker.number for marker in self.markers)
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        parameters.errorCorrectionRate = 0.0  # a tray with fruit in it may be a marker but for a bit
        detector = cv2.aruco.ArucoDetector(dictionary(self.dictionary, last), parameters)
        corners, numbers, _ = detector.detectMarkers(grey)
        read = [] if numbers is None else np.ravel(numbers).tolist()
        known = {marker.number: marker.corners for marker in self.markers if read.count(marker.number) == 1}
        found = [(known[number], points(px)) for number, px in zip(read, corners, strict=True) if number in known]
        if not found:
            return None
        places, pixels = zip(*found, strict=True)
        return np.concatenate(places), np.concatenate(pixels).astype(np.float64)


@dataclass(frozen=True)
class BaseBoard:
    """A ChArUco board fixed flat in the base frame, in place of single markers; place and yaw as of a `Marker`."""

    board: CharucoBoard
    x: float
    y: float
    yaw: float = 0.0
    z: float = 0.0

    @property
    def description(self) -> str:
        """What to look for, in words."""
        return f"board of {self.board.columns} x {self.board.rows}, from number {self.board.first_id}"

    def seen(self, grey: Picture) -> Seen | None:
        """Return its corners in a grey picture."""
        if (found := self.board.seen(grey)) is None:
            return None
        half = np.array([self.board.columns, self.board.rows]) * self.board.square / 2.0
        return _on_base((found[0][:, :2] - half) * [1.0, -1.0], self), found[1]


Board: TypeAlias = CharucoBoard | Checkerboard
Base: TypeAlias = BaseMarkers | BaseBoard  # what is fixed in the base frame for the camera to see


def _on_base(flat: Array, at: Marker | BaseBoard) -> Array:
    """Return points of something flat (N, 2), m, its y upwards, in the base frame (N, 3)."""
    return np.column_stack([placed((at.x, at.y), at.yaw, flat), np.full(len(flat), at.z)])
