"""The whole packing cell."""

from math import pi

from pydantic import Field

from layflat.arrays import Array
from layflat.cell.file.conveyor import Conveyor
from layflat.cell.file.imaging import BaseMarkers, Board, Camera, Light, Network, Overview
from layflat.cell.file.parts import Container, Cup, HandlingLimits, Lift, Mount, Table, Tray
from layflat.cell.file.produce import Clutter, Produce, Spread
from layflat.cell.geometry import rectangle
from layflat.description.part import Described
from layflat.machine import Machine


def floor_of(source: Tray | Conveyor) -> float:
    """Return how high over the table fruit lies in a tray or on a conveyor, m."""
    return source.wall if isinstance(source, Tray) else source.height


class Cell(Described):
    """A validated description; `file.build` makes it and checks that it can be."""

    machine: Machine = Field(description="built-in name or file of the arm")
    mount: Mount
    table: Table
    lift: Lift
    cup: Cup
    camera: Camera
    overview: Overview
    base_markers: BaseMarkers
    board: Board = Field(description="held before the camera to calibrate it")
    ambient: Spread = Field(description="light from everywhere, 1 for a white that fills the picture's range")
    light: dict[str, Light]
    produce: dict[str, Produce]
    tray: dict[str, Tray] = Field(default_factory=dict)
    conveyor: Conveyor | None = Field(default=None, description="brings produce, in place of trays")
    container: dict[str, Container]
    network: Network | None = Field(default=None, description="detects produce; default: colours do")
    clutter: dict[str, Clutter] = Field(default_factory=dict)
    limits: HandlingLimits

    @property
    def incoming(self) -> dict[str, Produce]:
        """Produce that comes, by kind."""
        return {kind: self.produce[kind] for source in self.sources.values() for kind in source.produce}

    @property
    def sources(self) -> dict[str, Tray | Conveyor]:
        """Trays or the conveyor, by which produce comes, by their keys in the file."""
        trays: dict[str, Tray | Conveyor] = {f"tray.{name}": tray for name, tray in self.tray.items()}
        return trays if self.conveyor is None else trays | {"conveyor": self.conveyor}

    @property
    def outlines(self) -> dict[str, Array]:
        """Corners of all that stands on the table, by its key in the file, (4, 2) m."""
        found = {name: source.outline for name, source in self.sources.items()}
        found |= {f"container.{name}": container.outline for name, container in self.container.items()}
        found |= {f"base_markers.marker.{name}": marker.outline for name, marker in self.base_markers.marker.items()}
        column = 2 * self.column_radius
        return found | {"the arm's column": rectangle((0.0, 0.0), 0.0, (column, column))}

    @property
    def column_radius(self) -> float:
        """Radius of the column under the first joint, m: that of its hose's cylinder."""
        return next(iter(self.machine.joints.values())).cylinder.diameter / 2

    @property
    def tallest_fruit(self) -> float:
        """Height of the tallest fruit that comes, m."""
        return max(kind.diameter.most * kind.flattening.most for kind in self.incoming.values())

    @property
    def heaviest_fruit(self) -> float:
        """Mass of the heaviest fruit that comes, taken for an ellipsoid, kg."""
        kinds = self.incoming.values()
        return max(pi / 6 * kind.diameter.most**3 * kind.flattening.most * kind.density.most for kind in kinds)

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
        """Return how high over the table fruit lies at a point (m), m."""
        return next((floor_of(source) for source in self.sources.values() if source.holds(x, y)), 0.0)

    def place_at(self, x: float, y: float) -> tuple[str, int] | None:
        """Return the container's name and the place's number that a point (m) is over, None where it is over none."""
        for name, container in self.container.items():
            if (number := container.place_at(x, y)) is not None:
                return name, number
        return None
