"""Validated description of a packing cell."""

from math import pi
from typing import Annotated, Self

from pydantic import Field, model_validator

from layflat.arrays import Array
from layflat.cell.file.imaging import BaseMarkersPart, Board, Camera, Light, Network, Overview
from layflat.cell.file.parts import (
    Bed,
    Colour,
    Container,
    CountRange,
    Cup,
    Duration,
    Extent,
    HandlingLimits,
    Lift,
    Mount,
    Size,
    Tray,
    WorkTable,
)
from layflat.cell.file.produce import Clutter, Produce, TruncatedNormal
from layflat.cell.geometry import rectangle_corners
from layflat.description import DescribedFile
from layflat.description import units as u
from layflat.machine import Machine

BeltSpeed = Annotated[u.AnySpeed, Field(ge=-0.5, le=0.5)]
BeltAcceleration = Annotated[u.PositiveAcceleration, Field(le=10.0)]


class Conveyor(Bed):
    """A level belt that moves along its x axis, on which fruit comes one by one."""

    rotation: u.Angle = Field(description="of its x axis, along which it moves, from the cell's")
    size: Size = Field(description="length and width of the belt")
    height: Extent = Field(description="of the belt above the table")
    colour: Colour
    produce: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="kinds that come on it, equally often")
    count: CountRange = Field(description="of fruit in a delivery")
    spacing: Size = Field(description="from one fruit's middle to the next along the belt: min and max")
    speeds: Annotated[tuple[tuple[u.TimeOrZero, BeltSpeed], ...], Field(min_length=1)] = Field(
        description="when the speed begins to change, from the delivery's beginning on, and what to"
    )
    acceleration: BeltAcceleration = Field(description="with which its speed changes")
    idle_timeout: Duration = Field(description="after which a delivery without fruit that can still be picked is over")

    @model_validator(mode="after")
    def _check_speeds_and_spacing(self) -> Self:
        """Raise ValueError unless speeds are in the order of their times and spacing is (min, max)."""
        times = [time for time, _ in self.speeds]
        if times != sorted(times):
            raise ValueError(f"speeds have the times {times} s; give them in the order of time")
        if self.spacing[0] > self.spacing[1]:
            raise ValueError("spacing has a min that is greater than its max; give the min first")
        return self

    @property
    def outline(self) -> Array:
        """Corners of the area of the table under it, (4, 2) m."""
        return rectangle_corners(self.centre, self.rotation, self.size)

    def demanded_speed(self, time: float) -> float:
        """Return the speed that is demanded of the belt at a time (s), m/s; 0 before the first of `speeds`."""
        return next((speed for since, speed in reversed(self.speeds) if since <= time), 0.0)


def floor_of(source: Tray | Conveyor) -> float:
    """Return the height above the table of the floor of a tray or the belt of a conveyor, m."""
    return source.wall if isinstance(source, Tray) else source.height


class Cell(DescribedFile):
    """A validated description; `file.loader.build_cell` makes it and checks that its parts fit together."""

    machine: Machine = Field(description="built-in name or file of the arm")
    mount: Mount
    table: WorkTable
    lift: Lift
    cup: Cup
    camera: Camera
    overview: Overview
    base_markers: BaseMarkersPart
    board: Board = Field(description="held before the camera to calibrate it")
    ambient: TruncatedNormal = Field(description="light from everywhere, 1 for a white that fills the picture's range")
    light: dict[str, Light]
    produce: dict[str, Produce]
    tray: dict[str, Tray] = Field(default_factory=dict)
    conveyor: Conveyor | None = Field(default=None, description="delivers produce, instead of trays")
    container: dict[str, Container]
    network: Network | None = Field(default=None, description="detects produce; default: colours do")
    clutter: dict[str, Clutter] = Field(default_factory=dict)
    limits: HandlingLimits

    @property
    def incoming(self) -> dict[str, Produce]:
        """Kinds of produce in trays or on the conveyor, by name."""
        return {kind: self.produce[kind] for source in self.sources.values() for kind in source.produce}

    @property
    def sources(self) -> dict[str, Tray | Conveyor]:
        """Trays or the conveyor, by which produce comes, by their keys in the file."""
        trays: dict[str, Tray | Conveyor] = {f"tray.{name}": tray for name, tray in self.tray.items()}
        return trays if self.conveyor is None else trays | {"conveyor": self.conveyor}

    @property
    def outlines(self) -> dict[str, Array]:
        """Corners of all parts on the table, by key in the file, (4, 2) m."""
        found = {name: source.outline for name, source in self.sources.items()}
        found |= {f"container.{name}": container.outline for name, container in self.container.items()}
        found |= {f"base_markers.marker.{name}": marker.outline for name, marker in self.base_markers.marker.items()}
        column = 2 * self.column_radius
        return found | {"the arm's column": rectangle_corners((0.0, 0.0), 0.0, (column, column))}

    @property
    def column_radius(self) -> float:
        """Radius of the column under the first joint, m: that of its hose's cylinder."""
        return next(iter(self.machine.joints.values())).cylinder.diameter / 2

    @property
    def tallest_fruit(self) -> float:
        """Height of the tallest fruit that comes, m."""
        return max(kind.diameter.max * kind.flattening.max for kind in self.incoming.values())

    @property
    def heaviest_fruit(self) -> float:
        """Mass of the heaviest fruit that comes, taken for an ellipsoid, kg."""
        kinds = self.incoming.values()
        return max(pi / 6 * kind.diameter.max**3 * kind.flattening.max * kind.density.max for kind in kinds)

    @property
    def obstacle_height(self) -> float:
        """Height over the table of all that the cup has to pass over: fruit in trays, and walls, m."""
        walls = [tray.height + tray.wall for tray in self.tray.values()]
        walls += [one.layout.height + one.layout.wall for one in self.container.values()]
        floors = [floor_of(source) for source in self.sources.values()]
        return max(self.tallest_fruit + max(floors), *walls)

    def tray_at(self, x: float, y: float) -> Tray | None:
        """Return the tray that a point (m) is over, None where it is over none."""
        return next((tray for tray in self.tray.values() if tray.holds(x, y)), None)

    def floor_at(self, x: float, y: float) -> float:
        """Return the height above the table of the tray's floor or belt at a point (m), m; 0 beside them."""
        return next((floor_of(source) for source in self.sources.values() if source.holds(x, y)), 0.0)

    def place_at(self, x: float, y: float) -> tuple[str, int] | None:
        """Return container (name) and place (number from 0, row by row) under a point (m); None beside them."""
        for name, container in self.container.items():
            if (number := container.place_at(x, y)) is not None:
                return name, number
        return None
