"""A closed vessel, or a hose chamber with its joint locked, that fills or empties through one path; what is fitted."""

from math import pi
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.identify.benches.contract import BenchDescription
from layflat.identify.unknown import ParameterSpec, factor_range, fixed_range
from layflat.physics.flow import sonic_conductance

GasName = Literal["air", "nitrogen", "oxygen", "hydrogen", "helium", "argon", "methane", "carbon dioxide"]


class Gas(Part):
    """What fills the vessel."""

    name: GasName = "air"
    law: Literal["ideal", "real"] = Field(default="real", description="real: Redlich-Kwong; ideal: air as in a joint")

    @model_validator(mode="after")
    def _known(self) -> Self:
        if self.law == "ideal" and self.name != "air":
            raise ValueError(f'the ideal law is that of air; give law = "real" for {self.name}')
        return self


class Space(Part):
    """The space that the gas fills, and the wall around it."""

    volume: u.Volume
    compliance: u.Compliance = Field(default=0.0, description="volume gained per pressure by a stretching wall")
    area: u.Area = Field(description="of the wall inside")
    diameter: u.Length = Field(description="of the vessel inside: the width that a jet that fills it has")


class VesselWall(Part):
    """How heat passes between gas, wall and surroundings."""

    natural: u.Share = Field(default=0.13, description="c of Nu = c Ra^(1/3), natural convection; 0 for none")
    forced: float = Field(default=0.56, ge=0, le=10, description="c_f of Nu = c_f Re^0.67, jet that fills; 0 for none")
    conductance: u.HeatConductance = Field(default=0.0, description="what passes whatever the gas does")
    heat_capacity: u.HeatCapacity | None = Field(default=None, description="without it, the wall keeps its temperature")
    outer_conductance: u.HeatConductance = Field(default=0.0, description="from the wall to the surroundings")


class FlowPath(Part):
    """The hole, valve or tube through which it fills or empties."""

    conductance: u.Conductance = Field(description="ISO 6358 sonic conductance (of air)")
    critical_ratio: Annotated[u.Share, Field(lt=0.99)] = Field(description="ISO 6358 critical pressure ratio")
    hole: u.Length | None = Field(default=None, description="diameter of an orifice, for its discharge coefficient")


class Place(Part):
    """Pressure and temperature somewhere."""

    pressure: u.PositivePressure = Field(description="absolute")
    temperature: u.Temperature


class VesselBench(BenchDescription):
    """A vessel, what it is joined to, and how it starts: gas and wall at rest, of one temperature."""

    kind: Literal["vessel"] = "vessel"
    gas: Gas
    space: Space
    wall: VesselWall
    path: FlowPath
    outside: Place = Field(description="on the other side of the path, where the log does not say")
    ambient: Place
    start: Place

    @model_validator(mode="after")
    def _rigid(self) -> Self:
        if self.gas.law == "real" and self.space.compliance > 0.0:
            raise ValueError('a stretching wall needs the ideal law of air; give gas.law = "ideal" or compliance 0')
        return self


FAST = "a fill or blow-down that is fast for the size of the vessel"


def _conductances(bench: VesselBench, C: float) -> tuple[float, float, bool]:
    if bench.path.hole is None:
        return C / 30.0, C * 30.0, True
    whole = float(sonic_conductance(0.25 * pi * bench.path.hole**2, 1.0))
    return min(0.2 * whole, 0.9 * C), max(1.1 * whole, 1.1 * C), True


BLOCKS = {
    "flow": (
        ParameterSpec("path.conductance", "m^3/(s Pa)", _conductances, "a fill or blow-down over a wide range"),
        ParameterSpec("path.critical_ratio", "1", fixed_range(0.05, 0.7), "flow down to nearly equal pressures"),
    ),
    "gas": (
        ParameterSpec("space.volume", "m^3", factor_range(10.0), "a second log with a known volume joined to it"),
        ParameterSpec("wall.natural", "1", fixed_range(0.01, 1.0, log=True), FAST),
        ParameterSpec("wall.forced", "1", fixed_range(0.02, 10.0, log=True), f"{FAST}: a fill"),
        ParameterSpec("wall.conductance", "W/K", factor_range(30.0), FAST),
    ),
}
"""What is fitted, by block: of the heat paths those that the description has and the logs excite."""

DESCRIPTION = VesselBench
