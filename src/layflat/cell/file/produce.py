"""Kinds of produce: distributions of size, shape, mass and colour, and grades; and clutter among them."""

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from layflat.cell.file.parts import Colour, CountRange, Extent, Friction
from layflat.description import Part, ordered
from layflat.description import units as u

Diameter = Annotated[u.Length, Field(ge=1e-3, le=0.5)]
Density = Annotated[u.Density, Field(ge=10.0, le=2e4)]


class TruncatedNormal(Part):
    """A normal distribution that is truncated at both ends."""

    mean: float
    std: Annotated[float, Field(ge=0)] = Field(description="standard deviation before truncation")
    min: float
    max: float

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        """Raise ValueError unless min <= mean <= max."""
        if not self.min <= self.mean <= self.max:
            raise ValueError(f"mean {self.mean:g} must lie between min {self.min:g} and max {self.max:g}")
        return self

    def draw(self, rng: np.random.Generator) -> float:
        """Return a random value between min and max, by rejection; it may use several random numbers."""
        while True:
            value = rng.normal(self.mean, self.std)
            if self.min <= value <= self.max:
                return float(value)


class LengthDistribution(TruncatedNormal):
    """A truncated normal distribution of lengths."""

    mean: Diameter
    std: Annotated[u.LengthOrZero, Field(le=0.5)]
    min: Diameter
    max: Diameter


class DensityDistribution(TruncatedNormal):
    """A truncated normal distribution of densities."""

    mean: Density
    std: Annotated[float, u.DENSITY, Field(ge=0)]
    min: Density
    max: Density


class Skin(Part):
    """A colour that this kind of produce comes in."""

    rgb: Colour
    std: u.Share = Field(description="relative standard deviation of brightness, and of each channel, half of it")
    fraction: Annotated[u.Share, Field(gt=0)] = Field(description="of the fruit, beside those of the other colours")


class Grade(Part):
    """Fruit that is packed together: limits of the diameter, and colours."""

    min: Diameter
    max: Diameter
    colours: Annotated[tuple[str, ...], Field(min_length=1)]

    _ordered = ordered("min", "max", "min must be below max, or it takes no fruit")


class Produce(Part):
    """A kind of produce: a body of revolution, wider than high."""

    shape: Literal["round", "mushroom"] = Field(description="an ellipsoid, or a cap on a stem")
    top: Literal["calyx", "stalk", "bare"] = Field(description="what is seen at its upper end")
    diameter: LengthDistribution
    flattening: TruncatedNormal = Field(description="height per diameter, a mushroom's stem included")
    density: DensityDistribution = Field(description="mass per volume")
    tilt: u.PositiveAngle = Field(description="greatest angle of its axis from upright as it is laid")
    friction: Friction
    rolling: Annotated[u.Length, Field(le=0.1)] = Field(description="resistance: arm of the contact force")
    colour: dict[str, Skin]
    grade: dict[str, Grade] = Field(description="the first that fits counts; what fits none is not packed")
    recognised: bool = Field(default=True, description="by vision; otherwise it is an unknown object")

    @model_validator(mode="after")
    def _check_colours(self) -> Self:
        """Raise ValueError without colours, or if a grade names an unknown one."""
        if not self.colour:
            raise ValueError("it has no colour; give a table such as [produce.tomato.colour.red]")
        for name, grade in self.grade.items():
            if unknown := set(grade.colours) - set(self.colour):
                raise ValueError(f"grade {name!r} names the colour {min(unknown)!r}; colours are {sorted(self.colour)}")
        return self

    def grade_of(self, diameter: float, colour: str) -> str | None:
        """Return the first grade with min <= diameter (m) < max and this colour; None if there is none."""
        grades = self.grade.items()
        return next((name for name, one in grades if one.min <= diameter < one.max and colour in one.colours), None)


class Clutter(Part):
    """Thin things that lie about in trays and on the table and are no produce."""

    shape: Literal["leaf", "sheet", "stick"]
    length: Extent
    width: Extent
    colour: Colour
    std: Annotated[u.Share, Field(le=0.3)] = Field(description="standard deviation of size and brightness, a fraction")
    count: CountRange = Field(description="in all trays and on the table together")
