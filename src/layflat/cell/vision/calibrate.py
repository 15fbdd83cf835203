"""A camera's lens from pictures of a board (Zhang 2000), its pose from one picture of the base's markers."""

from collections.abc import Sequence

import numpy as np

from layflat.arrays import Picture
from layflat.cell.extras import one_thread, opencv
from layflat.cell.vision.boards import Array, Base, Board, Seen
from layflat.cell.vision.calibration import Calibration
from layflat.cell.vision.prepare import check_picture
from layflat.errors import CameraError

FEWEST_VIEWS = 6
LEAST_TILT = 15.0  # between two of the views at least, degree
FOCAL_UNSURE = 0.003  # share of the focal length that its standard deviation may be
MOST_ERROR = 1.0  # rms of corners seen less corners predicted over which something is wrong with the board, px
OFF = 1.0e-3  # how far base markers may be from where the calibration says before a picture is refused, m on the table


def calibrate(pictures: Sequence[Picture], board: Board, base_picture: Picture, markers: Base) -> Calibration:
    """Calibrate a camera's lens by pictures of a board, and its pose by one of the base's markers from where it stays.

    The board is tilted and in all parts of the picture; pictures without it are left out. Raise PictureError if a
    picture is black, blurred or of another size, CameraError for too few views, views too much alike, a board of
    another size than given, or no marker detected.
    """
    size = (base_picture.shape[1], base_picture.shape[0])
    matrix, distortion, error = _lens(_views(pictures, board, size), size)
    seen = _seen_markers(base_picture, markers, size, "base picture")
    rotation, shift, pose_error = _pose(seen, matrix, distortion)
    return Calibration(
        picture_px=size, camera_matrix_px=matrix.tolist(), distortion=tuple(distortion.tolist()),
        rotation=rotation.tolist(), translation_m=tuple(shift.tolist()),
        lens_error_px=error, pose_error_px=pose_error,
    )  # fmt: skip


def self_check(picture: Picture, calibration: Calibration, markers: Base) -> float:
    """Return how far the base's markers are from where the calibration says, m on the table.

    Raise PictureError if the picture can't be used, CameraError if no marker is seen, or one is off by more than `OFF`.
    """
    places, pixels = _seen_markers(picture, markers, calibration.picture_px, "self-check")
    seen = np.array([calibration.to_table(px, z) for px, z in zip(pixels, places[:, 2], strict=True)])
    off = float(np.linalg.norm(seen - places[:, :2], axis=1).max())
    if off > OFF:
        problem = f"base markers are off by {off * 1e3:.1f} mm (at z = {places[0, 2]:g} m)"
        right = f"at most {OFF * 1e3:g} mm: the camera was moved or is miscalibrated; calibrate it anew"
        raise CameraError(problem, where="self-check", right=right)
    return off


def _grey(picture: Picture, size: tuple[int, int], where: str) -> Picture:
    check_picture(picture, size, where=where)
    grey: Picture = opencv().cvtColor(picture, opencv().COLOR_RGB2GRAY)
    return grey


def _views(pictures: Sequence[Picture], board: Board, size: tuple[int, int]) -> list[Seen]:
    seen = [board.seen(_grey(picture, size, f"board picture {i}")) for i, picture in enumerate(pictures, start=1)]
    views = [view for view in seen if view is not None]
    if len(views) < FEWEST_VIEWS:
        right = f"show it in at least {FEWEST_VIEWS}, tilted, in all parts of the picture; check its squares' number"
        raise _failed(f"the board is detected in {len(views)} of {len(pictures)} pictures", right)
    return views


def _lens(views: list[Seen], size: tuple[int, int]) -> tuple[Array, Array, float]:
    cv2 = opencv()
    known = [place.astype(np.float32) for place, _ in views]
    found = [pixels.astype(np.float32) for _, pixels in views]
    with one_thread():
        error, matrix, distortion, turns, _, spread, _, _ = cv2.calibrateCameraExtended(known, found, size, None, None)
    ahead = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns])
    tilt = float(np.degrees(np.arccos(np.clip(ahead @ ahead.T, -1.0, 1.0)).max()))
    if tilt < LEAST_TILT:
        right = "tilt it by 20 to 40 degrees, to all sides: flat views don't determine the focal length"
        raise _failed(f"the board is tilted by {tilt:.0f} degrees at most between views", right)
    unsure = float(np.max(np.ravel(spread)[:2]) / matrix[0, 0])
    if not np.isfinite(unsure) or unsure > FOCAL_UNSURE:
        raise _failed(f"the focal length is uncertain by {unsure:.1%}", "show the board in more views")
    if error > MOST_ERROR:
        right = f"at most {MOST_ERROR:g} px: the board must be flat, with as many squares as given"
        raise _failed(f"the board's corners are off by {error:.1f} px", right)
    return matrix, np.ravel(distortion)[:5].astype(np.float64), float(error)


def _seen_markers(picture: Picture, markers: Base, size: tuple[int, int], where: str) -> Seen:
    if (seen := markers.seen(_grey(picture, size, where))) is None:
        problem = f"no base marker ({markers.description}) is in the image"
        raise CameraError(problem, where=where, right="uncover it, point the camera at it")
    return seen


def _pose(seen: Seen, matrix: Array, distortion: Array) -> tuple[Array, Array, float]:
    cv2 = opencv()
    places, pixels = seen
    found, turn, shift = cv2.solvePnP(places, pixels, matrix, distortion, flags=cv2.SOLVEPNP_SQPNP)
    if not found:
        raise _failed("no pose fits the base's markers", "check their places and sides")
    turn, shift = cv2.solvePnPRefineLM(places, pixels, matrix, distortion, turn, shift)
    predicted, _ = cv2.projectPoints(places, turn, shift, matrix, distortion)
    error = float(np.sqrt(np.mean(np.sum((predicted.reshape(-1, 2) - pixels) ** 2, axis=1))))
    if error > MOST_ERROR:
        right = f"at most {MOST_ERROR:g} px: check their numbers, places and sides"
        raise _failed(f"base markers are off by {error:.1f} px in any pose", right)
    return cv2.Rodrigues(turn)[0], np.ravel(shift), error


def _failed(problem: str, right: str) -> CameraError:
    return CameraError(problem, where="calibration", right=right)
