"""What a camera's picture means on the table: rays of pixels, and pixels of points.

Camera frame as in OpenCV: x right, y down, z ahead; pixel (0, 0) is the middle of the first pixel. Lens: Brown (1966),
k1, k2, p1, p2, k3.
"""

from functools import cached_property
from pathlib import Path
from typing import TypeAlias

import numpy as np
import tomli_w
from numpy.typing import ArrayLike
from pydantic import ValidationError, field_validator

from layflat.arrays import Array
from layflat.cell.extras import opencv, points
from layflat.description import Part
from layflat.description.explain import explained
from layflat.description.tables import parsed
from layflat.description.text import read_text, told_as
from layflat.errors import CameraError
from layflat.files import write_text

Triple: TypeAlias = tuple[float, float, float]


class Calibration(Part):
    """A camera's lens and pose, as calibrated."""

    picture_px: tuple[int, int]  # width and height of its pictures
    camera_matrix_px: tuple[Triple, Triple, Triple]  # focal lengths and principal point
    distortion: tuple[float, float, float, float, float]  # k1, k2, p1, p2, k3
    rotation: tuple[Triple, Triple, Triple]  # from the base frame to the camera's
    translation_m: Triple  # of the base's origin in the camera frame
    lens_error_px: float  # rms of what was seen less what lens and pose predict
    pose_error_px: float

    @field_validator("rotation")
    @classmethod
    def _is_rotation(cls, rotation: tuple[Triple, Triple, Triple]) -> tuple[Triple, Triple, Triple]:
        R = np.array(rotation)
        if not np.allclose(R @ R.T, np.eye(3), atol=1e-6) or np.linalg.det(R) < 0.0:
            raise ValueError("is not a rotation; its rows must be perpendicular, of length 1 and right-handed")
        return rotation

    @cached_property
    def matrix(self) -> Array:
        """The camera matrix as an array, px."""
        return np.array(self.camera_matrix_px)

    @cached_property
    def to_camera(self) -> Array:
        """The rotation as an array."""
        return np.array(self.rotation)

    @cached_property
    def position(self) -> Array:
        """Where the camera is in the base frame, m."""
        return np.asarray(-self.to_camera.T @ np.array(self.translation_m))

    def rays(self, pixels: ArrayLike) -> Array:
        """Return the directions in which pixels look: (..., 2) px to (..., 3) unit vectors in the base frame."""
        cv2 = opencv()
        px = np.asarray(pixels, dtype=np.float64)
        until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-9)
        straight = cv2.undistortPoints(px.reshape(-1, 1, 2), self.matrix, np.array(self.distortion), criteria=until)
        ahead = np.column_stack([points(straight), np.ones(px.size // 2)])
        ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
        return np.asarray(ahead @ self.to_camera).reshape(*px.shape[:-1], 3)

    def to_table(self, pixels: ArrayLike, height: float = 0.0) -> Array:
        """Return where pixels (..., 2) look at the plane z = `height` (m): x, y (..., 2), m in the base frame."""
        rays = self.rays(pixels)
        far = (height - self.position[2]) / rays[..., 2:]
        return np.asarray(self.position[:2] + far * rays[..., :2])

    def to_pixels(self, places: ArrayLike) -> Array:
        """Return where points (..., 3), m in the base frame, are in the picture: (..., 2) px."""
        cv2 = opencv()
        xyz = np.asarray(places, dtype=np.float64)
        turn, _ = cv2.Rodrigues(self.to_camera)
        shift = np.array(self.translation_m)
        seen, _ = cv2.projectPoints(xyz.reshape(-1, 1, 3), turn, shift, self.matrix, np.array(self.distortion))
        return np.asarray(points(seen)).reshape(*xyz.shape[:-1], 2)

    def pixels_per_metre(self, height: float = 0.0) -> float:
        """Return the resolution (px/m) where the picture's middle meets the plane z = `height` (m)."""
        middle = np.array([self.picture_px]) / 2.0
        corners = middle + np.array([[-0.5, 0.0], [0.5, 0.0], [0.0, -0.5], [0.0, 0.5]])
        left, right, above, below = self.to_table(corners, height)
        return 2.0 / float(np.linalg.norm(right - left) + np.linalg.norm(below - above))

    def save(self, path: Path) -> Path:
        """Write it as TOML; raise OutputError where that can't be."""
        return write_text(path, tomli_w.dumps(self.model_dump()))


def load_calibration(path: Path) -> Calibration:
    """Load a calibration from its TOML file; raise CameraError if that is missing, broken, or no calibration."""
    where, right = str(path), "calibrate the camera anew"
    with told_as(CameraError):
        plain = parsed(read_text(path, where, right), where, "picture_px = [1280, 960]")
    try:
        return Calibration.model_validate(plain)
    except ValidationError as error:
        raise explained(error, where, Calibration, CameraError, right) from None
