"""Kinds of produce: how their size, shape, mass and colour are spread, and what grades they are packed by."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from layflat.cell.file.parts import Colour
from layflat.description import Part
from layflat.description import units as u


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
        """One value."""
        while True:
            value = rng.normal(self.mean, self.spread)
            if self.least <= value <= self.most:
                return float(value)


class LengthSpread(Spread):
    """A spread of lengths."""

    mean: u.Length
    spread: u.LengthOrZero
    least: u.Length
    most: u.Length


class DensitySpread(Spread):
    """A spread of densities."""

    mean: u.Density
    spread: Annotated[float, u.DENSITY, Field(ge=0)]
    least: u.Density
    most: u.Density


class Skin(Part):
    """A colour that this kind of produce comes in."""

    rgb: Colour
    spread: u.Share = Field(description="standard deviation of brightness, as a share, and of each channel, half of it")
    share: Annotated[u.Share, Field(gt=0)] = Field(description="of the fruit, beside the shares of the other colours")


class Grade(Part):
    """What is packed together."""

    least: u.Length = Field(description="diameter")
    most: u.Length = Field(description="diameter")
    colours: Annotated[tuple[str, ...], Field(min_length=1)]


class Produce(Part):
    """A kind of produce: a body of revolution, wider than high."""

    shape: Literal["round", "mushroom"] = Field(description="an ellipsoid, or a cap on a stem")
    top: Literal["calyx", "stalk", "bare"] = Field(description="what is seen at its upper end")
    diameter: LengthSpread
    flattening: Spread = Field(description="height per diameter, a mushroom's stem included")
    density: DensitySpread = Field(description="mass per volume")
    tilt: u.PositiveAngle = Field(description="greatest angle of its axis from upright as it is laid")
    friction: u.Ratio
    rolling: u.Length = Field(description="resistance to rolling: arm of the contact force; soft skin has much")
    colour: dict[str, Skin]
    grade: dict[str, Grade] = Field(description="the first that fits counts; what fits none is not packed")
    known: bool = Field(default=True, description="whether vision is told of it; what it is not told of is a stranger")

    @model_validator(mode="after")
    def _known(self) -> Self:
        for name, grade in self.grade.items():
            unknown = [colour for colour in grade.colours if colour not in self.colour]
            if unknown:
                raise ValueError(f"grade {name!r} names the colour {unknown[0]!r}; colours are {sorted(self.colour)}")
        if not self.colour:
            raise ValueError("it has no colour; give a table such as [produce.tomato.colour.red]")
        return self

    def grade_of(self, diameter: float, colour: str) -> str | None:
        """The first grade that takes a fruit, None if none does."""
        for name, grade in self.grade.items():
            if grade.least <= diameter < grade.most and colour in grade.colours:
                return name
        return None
