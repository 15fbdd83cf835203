"""Calibration targets: a ChArUco board or a checkerboard, and the markers fixed beside the arm."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import DICTIONARY, Array, CharucoBoard, PointPairs, as_rows, marker_dictionary, opencv
from layflat.cell.geometry import to_parent_frame
from layflat.errors import CameraError


@dataclass(frozen=True)
class Checkerboard:
    """Checkerboard without markers, which has to be completely in view."""

    columns: int  # of squares; one of columns and rows is odd, the other even, so that its orientation is unique
    rows: int
    square: float  # side, m

    def detect(self, grey: Picture) -> PointPairs | None:
        """Return its inner corners and their pixels in a grey picture; None where it is not completely in view."""
        cv2 = opencv()
        inner = (self.columns - 1, self.rows - 1)
        found, corners = cv2.findChessboardCornersSB(grey, inner, flags=cv2.CALIB_CB_ACCURACY)
        if not found:
            return None
        across, down = np.meshgrid(np.arange(inner[0]), np.arange(inner[1]))
        known = np.column_stack([across.ravel(), down.ravel(), np.zeros(across.size)]) * self.square
        return known, np.asarray(as_rows(corners), dtype=np.float64)


@dataclass(frozen=True)
class Marker:
    """ArUco marker that lies flat at a known position in the base frame."""

    number: int  # in the dictionary
    x: float  # of its middle, m
    y: float
    side: float  # m
    yaw: float = 0.0  # from the base's x axis to its upper edge, about z, rad
    z: float = 0.0  # height, m

    @property
    def corners(self) -> Array:
        """Corners in the base frame, from the upper left one clockwise as seen from above, (4, 3), m."""
        half = np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]) * self.side / 2.0
        return _on_base(half, self)


@dataclass(frozen=True)
class BaseMarkers:
    """Markers fixed in the base frame, each with its own number; several that are far apart give an exact pose."""

    markers: tuple[Marker, ...]
    dictionary: str = DICTIONARY

    def __post_init__(self) -> None:
        """Raise CameraError without markers, or if two have one number."""
        numbers = [marker.number for marker in self.markers]
        if not numbers or len(set(numbers)) < len(numbers):
            right = "give at least one, each with its own number"
            raise CameraError(f"have the numbers {numbers}", where="base markers", right=right)

    @property
    def description(self) -> str:
        """Numbers of the markers, such as "1, 2, 3", for messages."""
        return ", ".join(str(marker.number) for marker in self.markers)

    def detect(self, grey: Picture) -> PointPairs | None:
        """Return corners and pixels of the markers in a grey picture; None where none is detected.

        A number that is read twice is left out.
        """
        cv2 = opencv()
        parameters, last = cv2.aruco.DetectorParameters(), max(marker.number for marker in self.markers)
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        parameters.errorCorrectionRate = 0.0  # a tray with fruit in it may be a marker but for a bit
        detector = cv2.aruco.ArucoDetector(marker_dictionary(self.dictionary, last), parameters)
        corners, numbers, _ = detector.detectMarkers(grey)
        read = [] if numbers is None else np.ravel(numbers).tolist()
        known = {marker.number: marker.corners for marker in self.markers if read.count(marker.number) == 1}
        found = [(known[number], as_rows(px)) for number, px in zip(read, corners, strict=True) if number in known]
        if not found:
            return None
        places, pixels = zip(*found, strict=True)
        return np.concatenate(places), np.concatenate(pixels).astype(np.float64)


@dataclass(frozen=True)
class BaseBoard:
    """ChArUco board fixed flat in the base frame, in place of single markers; position and yaw as of a `Marker`."""

    board: CharucoBoard
    x: float
    y: float
    yaw: float = 0.0
    z: float = 0.0

    @property
    def description(self) -> str:
        """Size and first marker of the board, in words, for messages."""
        return f"board of {self.board.columns} x {self.board.rows}, from number {self.board.first_id}"

    def detect(self, grey: Picture) -> PointPairs | None:
        """Return its corners and their pixels in a grey picture; None where too few are detected."""
        if (found := self.board.detect(grey)) is None:
            return None
        half = np.array([self.board.columns, self.board.rows]) * self.board.square / 2.0
        return _on_base((found[0][:, :2] - half) * [1.0, -1.0], self), found[1]


Board: TypeAlias = CharucoBoard | Checkerboard
Base: TypeAlias = BaseMarkers | BaseBoard  # target that is fixed in the base frame


def _on_base(flat: Array, target: Marker | BaseBoard) -> Array:
    """Return points of a flat target (N, 2), m, its y upwards, in the base frame (N, 3)."""
    return np.column_stack([to_parent_frame((target.x, target.y), target.yaw, flat), np.full(len(flat), target.z)])
