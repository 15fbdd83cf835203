"""What the camera is and sees: lens, sensor, lights, board, markers."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from layflat.cell.file.parts import Point, Spot
from layflat.cell.file.produce import Spread
from layflat.description import Part
from layflat.description import units as u

Pixels = Annotated[int, Field(ge=16, le=8192)]
Squares = Annotated[int, Field(ge=3, le=40)]


class Distortion(Part):
    """Brown and Conrady's coefficients, as OpenCV has them."""

    k1: float
    k2: float
    p1: float
    p2: float
    k3: float


class Camera(Part):
    """The overhead camera; the picture's upper side is the cell's +y where `turn` is 0 and it looks straight down."""

    position: Point
    looks_at: Point
    turn: u.Angle = Field(description="about its line of sight, counter-clockwise seen from above")
    width: Pixels
    height: Pixels
    pixel: u.Length = Field(description="pitch of the sensor")
    focal_length: u.Length
    principal_offset: tuple[float, float] = Field(description="of the lens's axis from the picture's middle, px")
    distortion: Distortion
    blur: Annotated[float, Field(ge=0)] = Field(description="of lens and motion, standard deviation in px")
    exposure: Annotated[float, Field(ge=0)] = Field(description="gain of brightness; 1 as the lights are")
    read_noise: Annotated[float, Field(ge=0)] = Field(description="grey levels, standard deviation")
    shot_noise: Annotated[float, Field(ge=0)] = Field(description="variance per grey level, in grey levels")

    @property
    def focal_pixels(self) -> float:
        """Focal length in pixels."""
        return self.focal_length / self.pixel


class Overview(Part):
    """A second camera for people, which shows the whole cell."""

    position: Point
    looks_at: Point
    field: u.PositiveAngle = Field(description="of view, from bottom to top")
    width: Pixels
    height: Pixels


class Light(Part):
    """A lamp, which is never quite the same."""

    position: Point
    looks_at: Point
    wander: u.LengthOrZero = Field(description="standard deviation of each coordinate of its position")
    brightness: Spread = Field(description="1 for a white that fills the picture's range")
    tint: u.Share = Field(description="standard deviation of each colour channel")
    shadows: bool


class Board(Part):
    """A ChArUco board."""

    columns: Squares
    rows: Squares
    square: u.Length
    marker: u.Length
    dictionary: str = Field(description="of OpenCV, such as DICT_4X4_50")
    first_id: Annotated[int, Field(ge=0)] = Field(description="of its markers")

    @property
    def size(self) -> tuple[float, float]:
        """Of the squares, m."""
        return self.columns * self.square, self.rows * self.square


class BaseMarker(Part):
    """A square marker that lies on the table."""

    number: Annotated[int, Field(ge=0)] = Field(description="in the dictionary")
    centre: Spot
    side: u.Length = Field(description="of its black square")
    turn: u.Angle = Field(description="of its upper edge from the cell's x axis")

    @property
    def rim(self) -> float:
        """Width of the white rim without which it is not seen, m."""
        return self.side / 4

    @property
    def size(self) -> tuple[float, float]:
        """With its rim, m."""
        whole = self.side + 2 * self.rim
        return whole, whole


class Network(Part):
    """A network that finds produce in the camera's pictures, in place of colours."""

    file: Annotated[str, Field(pattern=r"\.onnx$")] = Field(description="ONNX, as seen from the cell's file")
    rows: Pixels = Field(description="of its input")
    columns: Pixels = Field(description="of its input")


class BaseMarkers(Part):
    """The markers by which the camera's place is found and checked."""

    dictionary: str = Field(description="of OpenCV, such as DICT_4X4_50")
    thickness: u.Length = Field(description="of the plates on which they are printed")
    marker: Annotated[dict[str, BaseMarker], Field(min_length=1)] = Field(description="four, far apart, are exact")
