"""Kinds of produce: how their size, shape, mass and colour are spread, and their grades; and clutter among them."""

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from layflat.cell.file.parts import Colour, Extent, Friction, Range
from layflat.description import Part, ordered
from layflat.description import units as u

Diameter = Annotated[u.Length, Field(ge=1e-3, le=0.5)]
Density = Annotated[u.Density, Field(ge=10.0, le=2e4)]


class Spread(Part):
    """A normal distribution that is cut off at both ends."""

    mean: float
    spread: Annotated[float, Field(ge=0)] = Field(description="standard deviation before it is cut off")
    least: float
    most: float

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.least <= self.mean <= self.most:
            raise ValueError("mean must lie between least and most")
        return self

    def draw(self, rng: np.random.Generator) -> float:
        """Draw one value."""
        while True:
            value = rng.normal(self.mean, self.spread)
            if self.least <= value <= self.most:
                return float(value)


class LengthSpread(Spread):
    """A spread of lengths."""

    mean: Diameter
    spread: Annotated[u.LengthOrZero, Field(le=0.5)]
    least: Diameter
    most: Diameter


class DensitySpread(Spread):
    """A spread of densities."""

    mean: Density
    spread: Annotated[float, u.DENSITY, Field(ge=0)]
    least: Density
    most: Density


class Skin(Part):
    """A colour that this kind of produce comes in."""

    rgb: Colour
    spread: u.Share = Field(description="standard deviation of brightness, as a share, and of each channel, half of it")
    share: Annotated[u.Share, Field(gt=0)] = Field(description="of the fruit, beside the shares of the other colours")


class Grade(Part):
    """Fruit that is packed together: limits of the diameter, and colours."""

    least: Diameter
    most: Diameter
    colours: Annotated[tuple[str, ...], Field(min_length=1)]

    _ordered = ordered("least", "most", "least must be below most, or it takes no fruit")


class Produce(Part):
    """A kind of produce: a body of revolution, wider than high."""

    shape: Literal["round", "mushroom"] = Field(description="an ellipsoid, or a cap on a stem")
    top: Literal["calyx", "stalk", "bare"] = Field(description="what is seen at its upper end")
    diameter: LengthSpread
    flattening: Spread = Field(description="height per diameter, a mushroom's stem included")
    density: DensitySpread = Field(description="mass per volume")
    tilt: u.PositiveAngle = Field(description="greatest angle of its axis from upright as it is laid")
    friction: Friction
    rolling: Annotated[u.Length, Field(le=0.1)] = Field(description="resistance: arm of the contact force")
    colour: dict[str, Skin]
    grade: dict[str, Grade] = Field(description="the first that fits counts; what fits none is not packed")
    known: bool = Field(default=True, description="whether vision knows it; otherwise it is an unknown object")

    @model_validator(mode="after")
    def _known(self) -> Self:
        if not self.colour:
            raise ValueError("it has no colour; give a table such as [produce.tomato.colour.red]")
        for name, grade in self.grade.items():
            if unknown := set(grade.colours) - set(self.colour):
                raise ValueError(f"grade {name!r} names the colour {min(unknown)!r}; colours are {sorted(self.colour)}")
        return self

    def grade_of(self, diameter: float, colour: str) -> str | None:
        """Return the first grade that takes a fruit, None if none does."""
        grades = self.grade.items()
        return next((name for name, one in grades if one.least <= diameter < one.most and colour in one.colours), None)


class Clutter(Part):
    """Thin things that lie about in trays and on the table and are no produce."""

    shape: Literal["leaf", "sheet", "stick"]
    length: Extent
    width: Extent
    colour: Colour
    spread: Annotated[u.Share, Field(le=0.3)] = Field(description="standard deviation of size and brightness, a share")
    count: Range = Field(description="in all trays and on the table together")
