"""The parts of a packing cell as a person describes them: arm, lift, cup, table, trays, containers, limits.

All numbers are SI floats once validated. Places are in the cell's frame: z up, the origin on the table under the arm's
first axis, x along link 1 at mid-stroke. Rotations are counter-clockwise seen from above.
"""

from typing import Annotated, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from layflat.arrays import Array
from layflat.cell.geometry import rectangle_corners, to_parent_frame
from layflat.description import Part, ordered
from layflat.description import units as u
from layflat.description.names import Name

Extent = Annotated[u.Length, Field(ge=1e-4, le=5.0)]  # a length of something in the cell, m
ExtentOrZero = Annotated[u.LengthOrZero, Field(le=5.0)]
LipDiameter = Annotated[u.Length, Field(ge=1e-3, le=0.2)]
Coordinate = Annotated[u.Coordinate, Field(ge=-10.0, le=10.0)]
PlanePoint = tuple[Coordinate, Coordinate]
Point = tuple[Coordinate, Coordinate, Coordinate]
Size = tuple[Extent, Extent]
Colour = tuple[u.Share, u.Share, u.Share]  # red, green and blue, 0 to 1
Duration = Annotated[u.Time, Field(ge=1e-4, le=60.0)]
Mass = Annotated[u.Mass, Field(gt=0, le=100.0)]
BodyMass = Annotated[u.Mass, Field(le=100.0)]
Force = Annotated[u.Force, Field(gt=0, le=1e4)]
Speed = Annotated[u.LinearSpeed, Field(ge=1e-3, le=20.0)]
Acceleration = Annotated[u.Acceleration, Field(gt=0, le=1e4)]
Friction = Annotated[u.Ratio, Field(le=10.0)]
Count = Annotated[int, Field(ge=0, le=200)]
Columns = Annotated[int, Field(ge=1, le=20)]


class Mount(Part):
    """Place and direction of the arm over the table."""

    height: Extent = Field(description="of the links' middle above the table")
    home: dict[str, u.Angle] = Field(description="angle of each joint when the arm is out of the camera's view")


class WorkTable(Part):
    """A level table."""

    centre: PlanePoint
    size: Size
    colour: Colour


class Lift(Part):
    """A vertical pneumatic cylinder at the tip, moved between its ends by a proportional valve."""

    stroke: Extent
    clearance: Extent = Field(description="of the cup's lip above the table while the lift is up")
    speed: Speed = Field(description="greatest, which its valve sets")
    acceleration: Acceleration = Field(description="greatest; its cushions keep it too")
    force: Force = Field(description="greatest, weight of its moving parts aside")
    mass: Mass = Field(description="of what moves up and down, with the cup")
    body: BodyMass = Field(description="mass of what stays up at the arm's tip: cylinder, guide, valves, ejector")
    pressure: Annotated[u.PositivePressure, Field(le=2e6)] = Field(description="gauge, at which it has its force")

    @model_validator(mode="after")
    def _check_clearance_and_force(self) -> Self:
        """Raise ValueError if stroke exceeds clearance, or force is not more than mass times acceleration."""
        if self.stroke > self.clearance:
            raise ValueError("stroke is longer than clearance: the cup would go through the table; give a shorter one")
        if self.force <= self.mass * self.acceleration:
            needed = self.mass * self.acceleration
            raise ValueError(f"force {self.force:g} N does not accelerate its mass; give more than {needed:g} N")
        return self


class Cup(Part):
    """A suction cup with its ejector."""

    diameter: LipDiameter = Field(description="of the lip")
    effective_diameter: LipDiameter = Field(description="of the area on which the vacuum acts")
    vacuum: Annotated[u.PositivePressure, Field(lt=101325)] = Field(description="below ambient, in a cup that is tight")
    build_up: Duration = Field(description="time constant with which the ejector makes the vacuum")
    leak: Duration = Field(description="time constant with which a cup on a fruit loses it")
    open_leak: Duration = Field(description="the same of a cup on nothing")
    release: Duration = Field(description="the same when the ejector is switched off and its valve lets air in")
    tilt: u.PositiveAngle = Field(description="greatest angle between the cup's axis and the skin under it")
    friction: Friction = Field(description="of lip on skin: sideways force per force of the vacuum")
    air_consumption: u.Flow = Field(description="of the ejector while it is on, normal volume")

    _fits = ordered("effective_diameter", "diameter", "effective_diameter is greater than diameter", may_equal=True)


class CountRange(Part):
    """Range of a count, from the smallest to the greatest."""

    min: Count
    max: Count

    _ordered = ordered("min", "max", "min is greater than max", may_equal=True)


class PlacedPart(Part):
    """A part that is placed level in the cell."""

    centre: PlanePoint
    rotation: u.Angle = Field(description="of its x axis from the cell's")

    def to_cell_frame(self, points: ArrayLike) -> Array:
        """Return points of the part's frame in the cell's frame, (n, 2) m."""
        return to_parent_frame(self.centre, self.rotation, points)

    def to_own_axes(self, points: ArrayLike) -> Array:
        """Return vectors of the cell's frame in components along the part's axes, (n, 2) m; they are only rotated."""
        return to_parent_frame((0.0, 0.0), -self.rotation, points)


class Bed(PlacedPart):
    """A level rectangle on which produce lies."""

    size: Size

    def from_centre(self, x: float, y: float) -> tuple[float, float]:
        """Return the vector from its centre to a point (m) of the cell's frame, along its axes, m."""
        along, across = self.to_own_axes([[x - self.centre[0], y - self.centre[1]]])[0].tolist()
        return along, across

    def holds(self, x: float, y: float) -> bool:
        """Return whether a point of the cell's frame (m) is inside of the rectangle, its edge excluded."""
        along, across = self.from_centre(x, y)
        return abs(along) < self.size[0] / 2 and abs(across) < self.size[1] / 2


class Tray(Bed):
    """An open box in which produce comes."""

    size: Size = Field(description="inside")
    height: Extent = Field(description="of its walls above its floor")
    wall: Extent = Field(description="thickness of walls and floor")
    colour: Colour
    produce: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="kinds that come in it, equally often")
    count: CountRange = Field(description="of fruit in it")
    touching_fraction: u.Share = Field(description="of the fruit: laid against another")

    @property
    def outline(self) -> Array:
        """Corners of the area of the table under it, (4, 2) m."""
        return rectangle_corners(
            self.centre, self.rotation, (self.size[0] + 2 * self.wall, self.size[1] + 2 * self.wall)
        )


class ContainerLayout(Part):
    """Layout of a container with places in rows and columns: the content of a layout file."""

    name: Name
    title: str
    columns: Columns = Field(description="places along x")
    rows: Columns = Field(description="places along y")
    pitch: Size = Field(description="from place to place along x and y")
    wall: Extent = Field(description="thickness of walls, dividers and floor")
    height: Extent = Field(description="of its outer walls above its floor")
    divider: ExtentOrZero = Field(description="height of what stands between the places, 0 for none")
    colour: Colour

    @property
    def opening(self) -> float:
        """Diameter of the greatest fruit that a place takes, m."""
        return min(self.pitch) - self.wall

    @property
    def size(self) -> tuple[float, float]:
        """Outer size, m."""
        return self.columns * self.pitch[0] + self.wall, self.rows * self.pitch[1] + self.wall

    @property
    def places(self) -> list[tuple[float, float]]:
        """Centres of the places from the container's centre, m, row by row."""
        x = [(i - (self.columns - 1) / 2) * self.pitch[0] for i in range(self.columns)]
        y = [(i - (self.rows - 1) / 2) * self.pitch[1] for i in range(self.rows)]
        return [(along, across) for across in y for along in x]


class Container(PlacedPart):
    """A punnet or tray on the table into which produce is packed."""

    layout: ContainerLayout = Field(description="built-in name or file")
    kind: str = Field(description="of the produce that belongs into it")
    grade: str = Field(description="of that produce")

    @property
    def outline(self) -> Array:
        """Corners of the area of the table under it, (4, 2) m."""
        return rectangle_corners(self.centre, self.rotation, self.layout.size)

    @property
    def places(self) -> Array:
        """Centres of its places in the cell's frame, (n, 2) m, row by row."""
        return self.to_cell_frame(self.layout.places)

    def place_at(self, x: float, y: float) -> int | None:
        """Return the number (from 0, row by row) of the place that a point (m) is over, None where it is over none."""
        away = self.to_own_axes(np.array([x, y]) - self.places)
        over = (2.0 * np.abs(away) < self.layout.pitch).all(axis=1)
        return int(np.argmax(over)) if over.any() else None


class HandlingLimits(Part):
    """Limits that the work must keep to."""

    acceleration: Acceleration = Field(description="greatest of a fruit, against bruises")
    speed: Speed = Field(description="greatest of the tip")
    contact_force: Force = Field(description="greatest of the cup on a fruit")
