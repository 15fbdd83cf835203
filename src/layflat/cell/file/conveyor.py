"""A conveyor that brings produce, as a person describes it."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from layflat.arrays import Array
from layflat.cell.file.parts import Bed, Colour, Duration, Extent, Range, Size
from layflat.cell.geometry import rectangle
from layflat.description import units as u

BeltSpeed = Annotated[u.AnySpeed, Field(ge=-0.5, le=0.5)]
BeltAcceleration = Annotated[u.PositiveAcceleration, Field(le=10.0)]


class Conveyor(Bed):
    """A level belt that moves along its x axis, on which fruit comes one by one."""

    rotation: u.Angle = Field(description="of its x axis, along which it moves, from the cell's")
    size: Size = Field(description="length and width of the belt")
    height: Extent = Field(description="of the belt above the table")
    colour: Colour
    produce: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="kinds that come on it, equally often")
    count: Range = Field(description="of fruit in a delivery")
    spacing: Size = Field(description="from one fruit's middle to the next along the belt: least and most")
    speeds: Annotated[tuple[tuple[u.TimeOrZero, BeltSpeed], ...], Field(min_length=1)] = Field(
        description="when the speed begins to change, from the delivery's beginning on, and what to"
    )
    acceleration: BeltAcceleration = Field(description="with which its speed changes")
    patience: Duration = Field(description="without fruit that can still be picked, after which the delivery is over")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        times = [time for time, _ in self.speeds]
        if times != sorted(times):
            raise ValueError("speeds are not in the order of their times")
        if self.spacing[0] > self.spacing[1]:
            raise ValueError("spacing gives a least that is greater than its most")
        return self

    @property
    def outline(self) -> Array:
        """Corners of what it covers of the table, (4, 2) m."""
        return rectangle(self.centre, self.rotation, self.size)

    def asked_speed(self, time: float) -> float:
        """Return the speed to which the belt's changes, or has changed, at a time (s), m/s."""
        return next((speed for since, speed in reversed(self.speeds) if since <= time), 0.0)
