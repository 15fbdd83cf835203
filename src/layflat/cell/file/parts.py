"""The parts of a packing cell as a person describes them: arm, lift, cup, table, trays, packs, limits.

All numbers are SI floats once validated. Places are in the cell's frame: z up, the origin on the table under the arm's
first axis, x along link 1 at mid-stroke.
"""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.names import Name

Spot = tuple[u.Coordinate, u.Coordinate]
Point = tuple[u.Coordinate, u.Coordinate, u.Coordinate]
Size = tuple[u.Length, u.Length]
Colour = tuple[u.Share, u.Share, u.Share]
"""Red, green and blue, 0 to 1."""

Count = Annotated[int, Field(ge=0, le=200)]


class Mount(Part):
    """How the arm stands over the table."""

    height: u.Length = Field(description="of the links' middle above the table")
    home: dict[str, u.Angle] = Field(description="angle of each joint when the arm is out of the camera's way")


class Table(Part):
    """A level table."""

    centre: Spot
    size: Size
    colour: Colour


class Lift(Part):
    """A vertical pneumatic cylinder at the tip, moved between its ends by a proportional valve."""

    stroke: u.Length
    clearance: u.Length = Field(description="of the cup's lip above the table while the lift is up")
    speed: u.LinearSpeed = Field(description="greatest, which its valve sets")
    acceleration: Annotated[u.Acceleration, Field(gt=0)] = Field(description="greatest; its cushions keep it too")
    force: Annotated[u.Force, Field(gt=0)] = Field(description="greatest, weight of its moving parts aside")
    mass: Annotated[u.Mass, Field(gt=0)] = Field(description="of what moves up and down, with the cup")
    body: u.Mass = Field(description="mass of what stays up at the arm's tip: cylinder, guide, valves, ejector")
    pressure: u.PositivePressure = Field(description="gauge, at which it has its force")

    @model_validator(mode="after")
    def _moves(self) -> Self:
        if self.stroke > self.clearance:
            raise ValueError("stroke is longer than clearance: the cup would go through the table")
        if self.force <= self.mass * self.acceleration:
            raise ValueError("force is not enough for mass and acceleration; give more than their product")
        return self


class Cup(Part):
    """A suction cup with its ejector."""

    diameter: u.Length = Field(description="of the lip")
    effective_diameter: u.Length = Field(description="of the area on which the vacuum acts")
    vacuum: Annotated[u.PositivePressure, Field(lt=101325)] = Field(description="below ambient, in a cup that is tight")
    build_up: u.Time = Field(description="time constant with which the ejector makes the vacuum")
    leak: u.Time = Field(description="time constant with which a cup on a fruit loses it")
    open_leak: u.Time = Field(description="the same of a cup on nothing")
    release: u.Time = Field(description="the same when the ejector is switched off and its valve lets air in")
    tilt: u.PositiveAngle = Field(description="greatest angle between the cup's axis and the skin under it")
    friction: u.Ratio = Field(description="of lip on skin: sideways force per force of the vacuum")
    air: u.Flow = Field(description="what the ejector takes while on, normal volume")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.effective_diameter > self.diameter:
            raise ValueError("effective_diameter is greater than diameter")
        return self


class Range(Part):
    """How many, from the fewest to the most."""

    least: Count
    most: Count

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.least > self.most:
            raise ValueError("least is greater than most")
        return self


class Tray(Part):
    """An open box in which produce comes."""

    centre: Spot
    turn: u.Angle = Field(description="of its x axis from the cell's")
    size: Size = Field(description="inside")
    height: u.Length = Field(description="of its walls above its floor")
    wall: u.Length = Field(description="thickness of walls and floor")
    colour: Colour
    produce: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="kinds that come in it, equally often")
    count: Range = Field(description="of fruit in it")
    touching: u.Share = Field(description="share of the fruit that is laid against another")


class Layout(Part):
    """A pack with places in rows and columns: the content of a layout file."""

    name: Name
    title: str
    columns: Annotated[int, Field(ge=1, le=20)] = Field(description="places along x")
    rows: Annotated[int, Field(ge=1, le=20)] = Field(description="places along y")
    pitch: Size = Field(description="from place to place along x and y")
    wall: u.Length = Field(description="thickness of walls, dividers and floor")
    height: u.Length = Field(description="of its outer walls above its floor")
    divider: u.LengthOrZero = Field(description="height of what stands between the places, 0 for none")
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
        """Centres of the places from the pack's centre, m, row by row."""
        x = [(i - (self.columns - 1) / 2) * self.pitch[0] for i in range(self.columns)]
        y = [(i - (self.rows - 1) / 2) * self.pitch[1] for i in range(self.rows)]
        return [(along, across) for across in y for along in x]


class Pack(Part):
    """A presentation pack on the table."""

    layout: Layout = Field(description="built-in name or file")
    centre: Spot
    turn: u.Angle = Field(description="of its x axis from the cell's")
    kind: str = Field(description="of the produce that belongs into it")
    grade: str = Field(description="of that produce")


class Limits(Part):
    """What the work must keep to."""

    acceleration: Annotated[u.Acceleration, Field(gt=0)] = Field(description="greatest of a fruit, against bruises")
    speed: u.LinearSpeed = Field(description="greatest of the tip")
    press: u.Force = Field(description="greatest of the cup on a fruit")
