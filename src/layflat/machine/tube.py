"""Description of the tube between a valve and a hose, and the values derived from its length and bore."""

from typing import Annotated, Any

from pydantic import Field

from layflat.description import Part
from layflat.description import units as u
from layflat.physics import line as laws
from layflat.physics.arrays import itemwise
from layflat.physics.flow import laminar_slope

WALL_CONDUCTANCE = 0.3
"""Heat flow from the wall of a tube per length and kelvin, W/(K m): laminar flow with a Nusselt number of 3.66."""


class TubePart(Part):
    """The tube from a valve to a hose."""

    length: Annotated[u.Length, Field(ge=0.01, le=20.0)]
    bore: Annotated[u.Length, Field(ge=1e-3, le=0.03)] = Field(description="inner diameter")
    conductance: u.Conductance | None = Field(
        default=None, description="ISO 6358 sonic conductance, fittings included; default: from length and bore"
    )
    critical_ratio: Annotated[u.Share, Field(lt=0.99)] | None = Field(
        default=None, description="ISO 6358 critical pressure ratio; default: from conductance and bore"
    )
    delay: u.TimeOrZero | None = Field(
        default=None, description="until a change at the valve reaches the hose; default: length over speed of sound"
    )
    wall_conductance: u.HeatConductance | None = Field(
        default=None, description=f"heat flow from wall to air per kelvin; default: {WALL_CONDUCTANCE:g} W/K per metre"
    )


def volume(line: TubePart) -> float:
    """Return the volume of a tube, m3."""
    return laws.tube_volume(line.length, line.bore)


def conductance(line: TubePart) -> float:
    """Return the sonic conductance of a tube, m3/(s Pa)."""
    if line.conductance is not None:
        return line.conductance
    return itemwise(laws.tube_conductance, line.length, line.bore)


def delay(line: TubePart) -> float:
    """Return the propagation delay of a pressure change through a tube, s."""
    return line.length / laws.SPEED_OF_SOUND if line.delay is None else line.delay


def parameters(line: TubePart | None) -> Any:
    """Return the parameters of a tube with half of its air, `NoLine` for None; the other half counts as dead volume."""
    if line is None:
        return laws.NoLine()
    through = conductance(line)
    ratio = line.critical_ratio
    if ratio is None:
        ratio = itemwise(laws.tube_critical_ratio, through, line.bore)
    wall = WALL_CONDUCTANCE * line.length if line.wall_conductance is None else line.wall_conductance
    return laws.LineParameters(0.5 * volume(line), through, ratio, itemwise(laminar_slope, ratio), 0.5 * wall)
