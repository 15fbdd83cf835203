"""The camera's lens: from an ideal picture, rendered wider than needed, to what the sensor gets."""

from functools import lru_cache
from math import atan

import numpy as np

from layflat.arrays import Array, Picture
from layflat.cell.extras import opencv
from layflat.cell.file.imaging import Camera
from layflat.cell.geometry import looking


class Optics:
    """Geometry of a camera in pinhole form with Brown and Conrady's distortion.

    Matrix (3, 3, px; pixel centres are whole numbers) and distortion are OpenCV's, the orientation is a quaternion of
    MuJoCo: it looks along its -z, x right, y up. The ideal picture is `wide` (px) and `field` high (rad).
    """

    def __init__(self, camera: Camera) -> None:
        f = camera.focal_pixels
        c_x = (camera.width - 1) / 2 + camera.principal_offset[0]
        c_y = (camera.height - 1) / 2 + camera.principal_offset[1]
        self.matrix: Array = np.array([[f, 0.0, c_x], [0.0, f, c_y], [0.0, 0.0, 1.0]])
        bent = camera.distortion
        self.distortion: Array = np.array([bent.k1, bent.k2, bent.p1, bent.p2, bent.k3])
        u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
        pixels = np.stack([u, v], axis=-1).reshape(-1, 1, 2).astype(np.float64)
        closely = (3, 50, 1e-12)  # steps and change at which the search ends
        ideal = opencv().undistortPoints(pixels, self.matrix, self.distortion, criteria=closely)
        rays = ideal.reshape(camera.height, camera.width, 2)
        half_width, half_height = f * np.abs(rays).max(axis=(0, 1)) + 2.0
        self.wide = (2 * int(np.ceil(half_width)), 2 * int(np.ceil(half_height)))
        self.field = 2.0 * atan(self.wide[1] / 2 / f)
        self.orientation = looking(camera.position, camera.looks_at, camera.rotation)
        middle = (np.array(self.wide) - 1.0) / 2.0
        self._from = (f * rays + middle).astype(np.float32)

    def bend(self, ideal: Picture) -> Picture:
        """Return what the lens makes of an ideal picture of size `wide`, (H, W, 3)."""
        bent: Picture = opencv().remap(ideal, self._from, None, opencv().INTER_LINEAR)
        return bent


optics_of = lru_cache(maxsize=8)(Optics)  # the optics of a camera, worked out once
