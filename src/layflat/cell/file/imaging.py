"""Descriptions of camera, lens and sensor, lights, calibration board, markers and network."""

from typing import Annotated

import numpy as np
from pydantic import Field

from layflat.arrays import Array
from layflat.cell.file.parts import Extent, PlanePoint, Point
from layflat.cell.file.produce import TruncatedNormal
from layflat.cell.geometry import look_at_orientation, rectangle_corners, rotate_vector
from layflat.description import Part
from layflat.description import units as u

Pixels = Annotated[int, Field(ge=16, le=8192)]
Coefficient = Annotated[float, Field(ge=-10.0, le=10.0)]
Levels = Annotated[float, Field(ge=0, le=255)]
Offset = Annotated[float, Field(ge=-8192.0, le=8192.0)]
Squares = Annotated[int, Field(ge=3, le=40)]
Wander = Annotated[u.LengthOrZero, Field(le=10.0)]


class Distortion(Part):
    """Brown and Conrady's coefficients, as OpenCV has them."""

    k1: Coefficient
    k2: Coefficient
    p1: Coefficient
    p2: Coefficient
    k3: Coefficient


class Camera(Part):
    """The overhead camera; the picture's upper side is the cell's +y if it looks straight down without rotation."""

    position: Point
    looks_at: Point
    rotation: u.Angle = Field(description="about its line of sight, counter-clockwise seen from above")
    width: Pixels
    height: Pixels
    pixel_pitch: Annotated[u.Length, Field(ge=5e-7, le=1e-4)] = Field(description="of the sensor")
    focal_length: Annotated[u.Length, Field(ge=5e-4, le=1.0)]
    principal_offset: tuple[Offset, Offset] = Field(description="of the lens's axis from the picture's middle, px")
    distortion: Distortion
    blur: Annotated[float, Field(ge=0, le=100)] = Field(description="of lens and motion, standard deviation in px")
    exposure: Annotated[float, Field(ge=0, le=1000)] = Field(description="gain of brightness; 1 as the lights are")
    read_noise: Levels = Field(description="grey levels, standard deviation")
    shot_noise: Levels = Field(description="variance per grey level, in grey levels")

    @property
    def focal_pixels(self) -> float:
        """Focal length in pixels."""
        return self.focal_length / self.pixel_pitch

    def sees(self, point: tuple[float, float]) -> bool:
        """Return whether a point of the table (m) is in the picture of a pinhole camera without distortion."""
        orientation = np.array(look_at_orientation(self.position, self.looks_at, self.rotation))
        x, y, z = rotate_vector(orientation * [1.0, -1.0, -1.0, -1.0], np.subtract([*point, 0.0], self.position))
        half = np.array([self.width, self.height]) / 2 / self.focal_pixels
        return bool(z < 0.0 and abs(x) < half[0] * -z and abs(y) < half[1] * -z)


class Overview(Part):
    """A second camera for people, which shows the whole cell."""

    position: Point
    looks_at: Point
    field_of_view: u.PositiveAngle = Field(description="from bottom to top")
    width: Pixels
    height: Pixels


class Light(Part):
    """A light that differs a little from scene to scene."""

    position: Point
    looks_at: Point
    position_std: Wander = Field(description="standard deviation of each coordinate of its position")
    brightness: TruncatedNormal = Field(description="1 for a white that fills the picture's range")
    colour_std: u.Share = Field(description="standard deviation of each colour channel")
    shadows: bool


class Board(Part):
    """A ChArUco board; lengths in m."""

    columns: Squares
    rows: Squares
    square: Extent
    marker: Extent
    dictionary: str = Field(description="of OpenCV, such as DICT_4X4_50")
    first_id: Annotated[int, Field(ge=0)] = Field(description="of its markers")

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of all squares, m."""
        return self.columns * self.square, self.rows * self.square


class BaseMarker(Part):
    """A square marker that lies on the table."""

    number: Annotated[int, Field(ge=0)] = Field(description="in the dictionary")
    centre: PlanePoint
    side: Extent = Field(description="of its black square")
    rotation: u.Angle = Field(description="of its upper edge from the cell's x axis")

    @property
    def rim(self) -> float:
        """Width of the white rim without which it is not detected, m."""
        return self.side / 4

    @property
    def outline(self) -> Array:
        """Corners of the area of the table under it with its rim, (4, 2) m."""
        whole = self.side + 2 * self.rim
        return rectangle_corners(self.centre, self.rotation, (whole, whole))


class Network(Part):
    """A network that detects produce in the camera's pictures, in place of colours."""

    file: Annotated[str, Field(pattern=r"\.onnx$")] = Field(description="ONNX, as seen from the cell's file")
    rows: Pixels = Field(description="of its input")
    columns: Pixels = Field(description="of its input")


class BaseMarkersPart(Part):
    """The markers by which the camera's pose is calibrated and checked."""

    dictionary: str = Field(description="of OpenCV, such as DICT_4X4_50")
    thickness: Extent = Field(description="of the plates on which they are printed")
    marker: Annotated[dict[str, BaseMarker], Field(min_length=1)] = Field(description="four, far apart, are exact")
