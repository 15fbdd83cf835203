"""Mapping between a camera's picture and the table: rays of pixels, and pixels of points.

Camera frame as in OpenCV: x right, y down, z ahead; pixel (0, 0) is the middle of the first pixel. Lens: Brown (1966),
k1, k2, p1, p2, k3; from pictures of a board (Zhang 2000), the pose from one picture of the base's markers.
"""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

import numpy as np
import tomli_w
from numpy.typing import ArrayLike
from pydantic import ValidationError, field_validator

from layflat.arrays import Picture
from layflat.cell.extras import Array, PointPairs, as_rows, opencv, single_thread
from layflat.cell.vision.boards import Base, Board
from layflat.cell.vision.prepare import check_picture
from layflat.description import Part
from layflat.description.explain import explain_error
from layflat.description.tables import parse_toml
from layflat.description.text import errors_as, read_text
from layflat.errors import CameraError
from layflat.files import write_text

Triple: TypeAlias = tuple[float, float, float]
MIN_VIEWS = 6
MIN_TILT = 15.0  # greatest angle between two of the views, lower limit, degree
MAX_FOCAL_DEVIATION = 0.003  # standard deviation of the focal length, as a fraction of it
MAX_CORNER_ERROR = 1.0  # rms of detected less predicted corners, beyond which the target's description is wrong, px
MAX_MARKER_ERROR = 1.0e-3  # position error of base markers beyond which the calibration is refused, m on the table


class Calibration(Part):
    """Calibration of a camera: lens and pose."""

    picture_px: tuple[int, int]  # width and height of its pictures
    camera_matrix_px: tuple[Triple, Triple, Triple]  # focal lengths and principal point
    distortion: tuple[float, float, float, float, float]  # k1, k2, p1, p2, k3
    rotation: tuple[Triple, Triple, Triple]  # from the base frame to the camera's
    translation_m: Triple  # of the base's origin in the camera frame
    lens_error_px: float  # rms of detected less predicted corners
    pose_error_px: float

    @field_validator("rotation")
    @classmethod
    def _check_rotation(cls, rotation: tuple[Triple, Triple, Triple]) -> tuple[Triple, Triple, Triple]:
        """Return the rotation; raise ValueError unless its rows are orthonormal and right-handed."""
        R = np.array(rotation)
        if not np.allclose(R @ R.T, np.eye(3), atol=1e-6) or np.linalg.det(R) < 0.0:
            raise ValueError("is not a rotation; its rows must be perpendicular, of length 1 and right-handed")
        return rotation

    @cached_property
    def matrix(self) -> Array:
        """Camera matrix as an array, px."""
        return np.array(self.camera_matrix_px)

    @cached_property
    def to_camera(self) -> Array:
        """Rotation from the base frame to the camera's, (3, 3)."""
        return np.array(self.rotation)

    @cached_property
    def position(self) -> Array:
        """Position of the camera in the base frame, (3,), m."""
        return np.asarray(-self.to_camera.T @ np.array(self.translation_m))

    def rays(self, pixels: ArrayLike) -> Array:
        """Return the rays of pixels: (..., 2) px, column and row, to (..., 3) unit vectors in the base frame."""
        cv2 = opencv()
        px = np.asarray(pixels, dtype=np.float64)
        until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-9)
        straight = cv2.undistortPoints(px.reshape(-1, 1, 2), self.matrix, np.array(self.distortion), criteria=until)
        ahead = np.column_stack([as_rows(straight), np.ones(px.size // 2)])
        ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
        return np.asarray(ahead @ self.to_camera).reshape(*px.shape[:-1], 3)

    def to_table(self, pixels: ArrayLike, height: float = 0.0) -> Array:
        """Return the points at which rays of pixels (..., 2) meet the plane z = `height` (m): x, y (..., 2), m.

        The result is wrong for rays that lead away from the plane.
        """
        rays = self.rays(pixels)
        far = (height - self.position[2]) / rays[..., 2:]
        return np.asarray(self.position[:2] + far * rays[..., :2])

    def to_pixels(self, places: ArrayLike) -> Array:
        """Return the pixels of points (..., 3), m in the base frame: (..., 2) px, column and row, with distortion.

        They may lie outside of the picture; those of points that are not in front of the camera are wrong.
        """
        cv2 = opencv()
        xyz = np.asarray(places, dtype=np.float64)
        turn, _ = cv2.Rodrigues(self.to_camera)
        shift = np.array(self.translation_m)
        seen, _ = cv2.projectPoints(xyz.reshape(-1, 1, 3), turn, shift, self.matrix, np.array(self.distortion))
        return np.asarray(as_rows(seen)).reshape(*xyz.shape[:-1], 2)

    def pixels_per_metre(self, height: float = 0.0) -> float:
        """Return the resolution (px/m) at the picture's middle on the plane z = `height` (m)."""
        middle = np.array([self.picture_px]) / 2.0
        corners = middle + np.array([[-0.5, 0.0], [0.5, 0.0], [0.0, -0.5], [0.0, 0.5]])
        left, right, above, below = self.to_table(corners, height)
        return 2.0 / float(np.linalg.norm(right - left) + np.linalg.norm(below - above))

    def save(self, path: Path) -> Path:
        """Write the calibration as TOML, and return the path; raise OutputError if it can't be written."""
        return write_text(path, tomli_w.dumps(self.model_dump()))


def load_calibration(path: Path) -> Calibration:
    """Load a calibration from its TOML file; raise CameraError if that is missing, broken, or no calibration."""
    where, right = str(path), "calibrate the camera anew"
    with errors_as(CameraError):
        plain = parse_toml(read_text(path, where, right), where, "picture_px = [1280, 960]")
    try:
        return Calibration.model_validate(plain)
    except ValidationError as error:
        raise explain_error(error, where, Calibration, CameraError, right) from None


def calibrate(pictures: Sequence[Picture], board: Board, base_picture: Picture, markers: Base) -> Calibration:
    """Calibrate a camera's lens by pictures of a board, and its pose by a picture of the base's markers.

    Args:
        pictures: (H, W, 3) RGB, of the board tilted and in all parts of the picture; those without it are left out.
        board: its description.
        base_picture: (H, W, 3) RGB, from the camera's final position.
        markers: target fixed in the base frame.

    Raises:
        PictureError: a picture is black, blurred or of another size.
        CameraError: there are too few or too similar views, the board has another size, or no marker is detected.
    """
    size = (base_picture.shape[1], base_picture.shape[0])
    matrix, distortion, error = _fit_lens(_detect_boards(pictures, board, size), size)
    seen = _detect_markers(base_picture, markers, size, "base picture")
    rotation, shift, pose_error = _fit_pose(seen, matrix, distortion)
    return Calibration(
        picture_px=size, camera_matrix_px=matrix.tolist(), distortion=tuple(distortion.tolist()),
        rotation=rotation.tolist(), translation_m=tuple(shift.tolist()),
        lens_error_px=error, pose_error_px=pose_error,
    )  # fmt: skip


def self_check(picture: Picture, calibration: Calibration, markers: Base) -> float:
    """Return the greatest position error of the base's markers under a calibration, m on the table.

    Args:
        picture: (H, W, 3) RGB.
        calibration: calibration of the camera.
        markers: target fixed in the base frame.

    Raises:
        PictureError: the picture can't be used.
        CameraError: no marker is detected, or the error exceeds `MAX_MARKER_ERROR`.
    """
    places, pixels = _detect_markers(picture, markers, calibration.picture_px, "self-check")
    detected = np.array([calibration.to_table(px, z) for px, z in zip(pixels, places[:, 2], strict=True)])
    error = float(np.linalg.norm(detected - places[:, :2], axis=1).max())
    if error > MAX_MARKER_ERROR:
        problem = f"base markers are off by {error * 1e3:.1f} mm (at z = {places[0, 2]:g} m)"
        right = f"at most {MAX_MARKER_ERROR * 1e3:g} mm: the camera was moved or is miscalibrated; calibrate it anew"
        raise CameraError(problem, where="self-check", right=right)
    return error


def _grey(picture: Picture, size: tuple[int, int], where: str) -> Picture:
    """Return an RGB picture in grey; raise PictureError if it can't be used or has another size (px)."""
    check_picture(picture, size, where=where)
    grey: Picture = opencv().cvtColor(picture, opencv().COLOR_RGB2GRAY)
    return grey


def _detect_boards(pictures: Sequence[Picture], board: Board, size: tuple[int, int]) -> list[PointPairs]:
    """Return the board's corners in each picture that shows it; raise CameraError if fewer than `MIN_VIEWS` do.

    Raise PictureError if a picture can't be used.
    """
    seen = [board.detect(_grey(picture, size, f"board picture {i}")) for i, picture in enumerate(pictures, start=1)]
    views = [view for view in seen if view is not None]
    if len(views) < MIN_VIEWS:
        right = f"show it in at least {MIN_VIEWS}, tilted, in all parts of the picture; check its squares' number"
        raise _calibration_error(f"the board is detected in {len(views)} of {len(pictures)} pictures", right)
    return views


def _fit_lens(views: list[PointPairs], size: tuple[int, int]) -> tuple[Array, Array, float]:
    """Return camera matrix, 5 distortion coefficients and RMS error (px) of the views of a board.

    Raise CameraError if views are too little tilted, the focal length is too uncertain, or corners are too far off.
    """
    cv2 = opencv()
    board_points = [place.astype(np.float32) for place, _ in views]
    pixels_found = [pixels.astype(np.float32) for _, pixels in views]
    with single_thread():
        error, matrix, distortion, turns, _, spread, _, _ = cv2.calibrateCameraExtended(
            board_points, pixels_found, size, None, None
        )
    ahead = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns])
    tilt = float(np.degrees(np.arccos(np.clip(ahead @ ahead.T, -1.0, 1.0)).max()))
    if tilt < MIN_TILT:
        right = "tilt it by 20 to 40 degrees, to all sides: flat views don't determine the focal length"
        raise _calibration_error(f"the board is tilted by {tilt:.0f} degrees at most between views", right)
    unsure = float(np.max(np.ravel(spread)[:2]) / matrix[0, 0])
    if not np.isfinite(unsure) or unsure > MAX_FOCAL_DEVIATION:
        raise _calibration_error(f"the focal length is uncertain by {unsure:.1%}", "show the board in more views")
    if error > MAX_CORNER_ERROR:
        right = f"at most {MAX_CORNER_ERROR:g} px: the board must be flat, with as many squares as given"
        raise _calibration_error(f"the board's corners are off by {error:.1f} px", right)
    return matrix, np.ravel(distortion)[:5].astype(np.float64), float(error)


def _detect_markers(picture: Picture, markers: Base, size: tuple[int, int], where: str) -> PointPairs:
    """Return places and pixels of the base markers in a picture.

    Raise CameraError if none is detected, PictureError if the picture can't be used; both name it `where`.
    """
    if (seen := markers.detect(_grey(picture, size, where))) is None:
        problem = f"no base marker ({markers.description}) is in the image"
        raise CameraError(problem, where=where, right="uncover it, point the camera at it")
    return seen


def _fit_pose(seen: PointPairs, matrix: Array, distortion: Array) -> tuple[Array, Array, float]:
    """Return rotation and translation (m) from the base frame to the camera's, and the RMS error of markers (px).

    Raise CameraError if no pose fits, or the error exceeds `MAX_CORNER_ERROR`.
    """
    cv2 = opencv()
    places, pixels = seen
    has_solution, turn, shift = cv2.solvePnP(places, pixels, matrix, distortion, flags=cv2.SOLVEPNP_SQPNP)
    if not has_solution:
        raise _calibration_error("no pose fits the base's markers", "check their places and sides")
    turn, shift = cv2.solvePnPRefineLM(places, pixels, matrix, distortion, turn, shift)
    predicted, _ = cv2.projectPoints(places, turn, shift, matrix, distortion)
    error = float(np.sqrt(np.mean(np.sum((predicted.reshape(-1, 2) - pixels) ** 2, axis=1))))
    if error > MAX_CORNER_ERROR:
        right = f"at most {MAX_CORNER_ERROR:g} px: check their ids, positions and side lengths"
        raise _calibration_error(f"base markers are off by {error:.1f} px in the best-fitting pose", right)
    return cv2.Rodrigues(turn)[0], np.ravel(shift), error


def _calibration_error(problem: str, right: str) -> CameraError:
    return CameraError(problem, where="calibration", right=right)
