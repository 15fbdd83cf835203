"""Linear friction rig: a cylinder's rod is pushed and pulled while its chamber is held at a pressure."""

from typing import Annotated, Literal, Self

from annotated_types import Ge, Le
from pydantic import Field, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.identify.benches import BenchDescription


class Piston(Part):
    """Force of the piston by pressure and position; position is zero where the log's is."""

    area: u.Area = Field(description="force per gauge pressure at position zero")
    area_slope: u.AreaPerLength = Field(default=0.0, description="growth of the area with position")
    area_growth: u.AreaPerPressure = Field(
        default=0.0, description="growth of the area with gauge pressure: of a seal that changes its shape"
    )
    area_slope_growth: u.AreaSlopePerPressure = Field(
        default=0.0, description="growth of area_slope with gauge pressure: of a seal that changes its shape"
    )
    spring: u.SpringRate = Field(default=0.0, description="force per position without pressure: a spring, or a tilt")
    offset: u.Force = Field(default=0.0, description="force at position zero without pressure: weight, sensor's zero")


class Friction(Part):
    """Friction of parallel elasto-slip elements, as in the losses of a joint, and of a film of lubricant."""

    base: u.ForceOrZero = Field(description="friction without pressure")
    slope: u.ForcePerPressure = Field(description="friction added per gauge pressure")
    exponent: Annotated[u.Ratio, Ge(0.2), Le(5.0)] = Field(
        default=1.0,
        description="power of the pressure in the added friction: above 1 the growth increases with pressure",
    )
    reference_pressure_gauge: u.PositivePressure = Field(
        description="pressure of the deflections, at which the added friction is slope times pressure for any exponent"
    )
    deflections: Annotated[tuple[u.Length, ...], Field(min_length=1)] = Field(
        description="travel after which each element slips, at reference pressure"
    )
    weights: Annotated[tuple[u.Share, ...], Field(min_length=1)] = Field(
        description="fraction of the friction without the film that each element has"
    )
    film_fraction: u.Share = Field(default=0.0, description="fraction of the friction that depends on the speed")
    film_speed: u.LinearSpeed = Field(default=0.005, description="speed at which the film has 76 % of its friction")
    profile: tuple[Annotated[float, Ge(-0.9), Le(9.0)], ...] = Field(
        default=(),
        description="additional friction along the stroke, as a fraction of the friction, at evenly spaced positions",
    )
    profile_from: u.Coordinate = Field(default=0.0, description="position of the first of them")
    profile_to: u.Coordinate = Field(default=0.0, description="position of the last of them")
    viscous: u.LinearDamping = Field(default=0.0, description="force per speed")

    @model_validator(mode="after")
    def _check_weights_and_profile(self) -> Self:
        """Raise ValueError unless weights fit deflections and add up to 1, and the profile has an extent."""
        if len(self.weights) != len(self.deflections):
            raise ValueError("weights must be as many as deflections")
        if abs(sum(self.weights) - 1.0) > 1e-9:
            raise ValueError("weights must add up to 1, for example [0.4, 0.3, 0.3]")
        if self.profile and not (len(self.profile) > 1 and self.profile_to > self.profile_from):
            raise ValueError("profile must have two items or more, and profile_to be greater than profile_from")
        return self


class RodBench(BenchDescription):
    """Bench of a friction rig: motion is imposed, force and chamber pressure are measured."""

    kind: Literal["friction rig"]
    ambient_pressure: u.PositivePressure = Field(description="absolute")
    piston: Piston
    friction: Friction
