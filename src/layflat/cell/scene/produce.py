"""What is drawn at random: fruit, where in its tray it is laid, and clutter, which is seen and touches nothing."""

from dataclasses import dataclass, replace
from math import cos, pi, sin
from typing import Any, Literal

import numpy as np

from layflat.arrays import Array
from layflat.cell.extras import UNTOUCHED, add_geom
from layflat.cell.file.conveyor import Conveyor
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Tray
from layflat.cell.file.produce import Clutter
from layflat.cell.geometry import about_z, overlap, product, rectangle
from layflat.errors import CellError

CAP = 0.72  # height of a mushroom's cap as a share of its whole height
STEM = 0.2  # radius of a mushroom's stem per diameter of its cap
TRIES = 400
GAP = 2e-3  # between fruit that does not touch, m, at least
CLUTTER_TRIES = 60  # to find room for a piece; one that finds none is left out
CLEAR = 1e-3  # between clutter and where fruit is laid, m: neither lies on the other
EDGE = 10e-3  # that fruit keeps to the sides of a belt, m
SHELF = -0.35  # height of the shelf under the table, m,
GRID = 15, 0.11  # and of what rests on it: how many a row, and how far apart, m
THIN = 2e-4  # half the thickness of leaves and sheets, m


@dataclass(frozen=True)
class Specimen:
    """A fruit, whatever happens to it: lengths in m, mass in kg."""

    name: str
    kind: str
    colour: str
    grade: str | None
    diameter: float
    height: float
    mass: float


@dataclass(frozen=True)
class SceneFruit(Specimen):
    """One fruit as it is drawn and laid, its middle at `position` in the cell's frame, m."""

    rgb: tuple[float, float, float]
    shape: str
    top: str
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    # Of fruit that comes on a belt: the belt's way by when it comes, and how far from its middle, m.
    comes: tuple[float, float] | None = None

    @property
    def under(self) -> float:
        """From its middle (that of a mushroom's cap) down to its lowest point, m."""
        return self.height - self.over

    @property
    def over(self) -> float:
        """From its middle up to its top, m."""
        return self.height / 2 if self.shape == "round" else CAP * self.height / 2


def fruit_of(cell: Cell, rng: np.random.Generator) -> list[SceneFruit]:
    """Draw random fruit for all trays, or the conveyor; raise CellError if a tray has no room for what is drawn."""
    found: list[SceneFruit] = []
    for name, tray in cell.tray.items():
        count = int(rng.integers(tray.count.least, tray.count.most + 1))
        drawn = [_drawn(cell, str(rng.choice(tray.produce)), len(found) + i, rng) for i in range(count)]
        diameters = [one.diameter for one in drawn]
        if (laid := next(filter(None, (_laid(diameters, tray, rng) for _ in range(20))), None)) is None:
            where = f"{cell.origin}: tray.{name}"
            raise CellError(f"has no room for {count} fruit", where=where, right="give a smaller count")
        spots, alone = laid
        for one, spot, free in zip(drawn, tray.placed(spots), alone, strict=True):
            position = float(spot[0]), float(spot[1]), tray.wall + one.under + GAP
            orientation = _tilted(cell.produce[one.kind].tilt if free else 0.0, rng)
            found.append(replace(one, position=position, orientation=orientation))
    return found if cell.conveyor is None else _coming(cell, cell.conveyor, rng)


def _coming(cell: Cell, belt: Conveyor, rng: np.random.Generator) -> list[SceneFruit]:
    """Draw fruit that comes on a belt, one after the other, each on the shelf until then."""
    found, way = [], 0.0
    for number in range(int(rng.integers(belt.count.least, belt.count.most + 1))):
        one = _drawn(cell, str(rng.choice(belt.produce)), number, rng)
        room = max(belt.size[1] / 2 - EDGE - one.diameter / 2, 0.0)
        position = (*on_shelf(belt.centre, number), SHELF + one.under + GAP)
        orientation = _tilted(cell.produce[one.kind].tilt, rng)
        comes = way, float(rng.uniform(-room, room))
        found.append(replace(one, position=position, orientation=orientation, comes=comes))
        way += float(rng.uniform(*belt.spacing))
    return found


def on_shelf(centre: tuple[float, float], number: int) -> tuple[float, float]:
    """Return where on the shelf under the table, about a centre (m), the fruit of a number rests, m."""
    row, column = divmod(number, GRID[0])
    return centre[0] + (column - GRID[0] // 2) * GRID[1], centre[1] + (row - GRID[0] // 2) * GRID[1]


def _drawn(cell: Cell, kind: str, number: int, rng: np.random.Generator) -> SceneFruit:
    produce = cell.produce[kind]
    diameter = produce.diameter.draw(rng)
    height = diameter * produce.flattening.draw(rng)
    shares = np.array([skin.share for skin in produce.colour.values()])
    colour = str(rng.choice(list(produce.colour), p=shares / shares.sum()))
    skin = produce.colour[colour]
    rgb = np.array(skin.rgb) * rng.normal(1.0, skin.spread) + rng.normal(0.0, skin.spread / 2, 3)
    red, green, blue = (float(channel) for channel in np.clip(rgb, 0.02, 0.98))
    if produce.shape == "round":
        volume = pi / 6 * diameter**2 * height
    else:
        stem = pi * (STEM * diameter) ** 2 * (1 - CAP) * height
        volume = pi / 6 * diameter**2 * CAP * height + stem
    mass = produce.density.draw(rng) * volume
    return SceneFruit(
        f"{kind}-{number}", kind, colour, produce.grade_of(diameter, colour), diameter, height, mass,
        (red, green, blue), produce.shape, produce.top,
    )  # fmt: skip


def _laid(diameters: list[float], tray: Tray, rng: np.random.Generator) -> tuple[Array, list[bool]] | None:
    """Return where fruit lies in a tray from its centre, (n, 2) in m, and which touch no other; None without room.

    What touches is laid upright: it would roll apart.
    """
    spots, alone = np.zeros((0, 2)), [True] * len(diameters)
    for i, diameter in enumerate(diameters):
        apart = (np.array(diameters[:i]) + diameter) / 2
        room = (np.array(tray.size) - diameter) / 2 - 1e-3
        leans = i > 0 and rng.random() < tray.touching
        for _ in range(TRIES):
            if leans:
                beside, angle = int(rng.integers(i)), rng.uniform(0.0, 2 * pi)
                spot = spots[beside] + (apart[beside] + 1e-4) * np.array([cos(angle), sin(angle)])
            else:
                spot = rng.uniform(-room, room)
            gaps = np.hypot(*(spots - spot).T) - apart
            if leans:
                gaps[beside] = np.inf
            if (np.abs(spot) <= room).all() and (gaps > GAP).all():
                spots = np.vstack([spots, spot])
                if leans:
                    alone[i] = alone[beside] = False
                break
        else:
            return None
    return spots, alone


def _tilted(most: float, rng: np.random.Generator) -> tuple[float, float, float, float]:
    """Draw a quaternion: any rotation about the upright axis, then a tilt up to `most` in any direction."""
    rotation, tilt, way = rng.uniform(0, 2 * pi), most * np.sqrt(rng.random()), rng.uniform(0, 2 * pi)
    tilted = np.array([cos(tilt / 2), sin(tilt / 2) * cos(way), sin(tilt / 2) * sin(way), 0.0])
    w, x, y, z = product(tilted, about_z(rotation)).tolist()
    return w, x, y, z


def add_clutter(spec: Any, cell: Cell, fruits: list[SceneFruit], rng: np.random.Generator) -> None:
    """Add random pieces to a spec, half of them in trays, half on the table."""
    taken = cell.outlines
    for sort, clutter in cell.clutter.items():
        for i in range(int(rng.integers(clutter.count.least, clutter.count.most + 1))):
            factor, bright = np.clip(rng.normal(1.0, clutter.spread, 2), 0.4, 1.6)
            size = (factor * clutter.length, factor * clutter.width)
            for _ in range(CLUTTER_TRIES):
                spot, floor = _thrown(cell, taken, max(size), rng)
                rotation = float(rng.uniform(0.0, pi))
                outline = rectangle((float(spot[0]), float(spot[1])), rotation, size)
                on_table = floor == 0.0 and any(overlap(outline, other) for other in taken.values())
                if not on_table and _free(spot, rotation, size, fruits):
                    colour = np.clip(bright * np.array(clutter.colour), 0.0, 1.0)
                    _add(spec, f"clutter.{sort}-{i}", clutter, size, [*spot, floor], rotation, colour)
                    break


def _thrown(cell: Cell, taken: dict[str, Array], reach: float, rng: np.random.Generator) -> tuple[Array, float]:
    """Draw a spot on the floor of a tray, or on the table among the parts; and how high it is, m."""
    names = list(cell.tray)
    if names and rng.random() < 0.5:
        tray = cell.tray[names[int(rng.integers(len(names)))]]
        room = np.maximum(np.array(tray.size) - reach, 0.0) / 2
        return tray.placed(rng.uniform(-room, room)), tray.wall
    corners = np.concatenate(list(taken.values()))
    return rng.uniform(corners.min(axis=0), corners.max(axis=0)), 0.0


def _free(spot: Array, rotation: float, size: tuple[float, float], fruits: list[SceneFruit]) -> bool:
    """Return whether a piece lies clear of where all fruit is laid."""
    if not fruits:
        return True
    way = np.array([fruit.position[:2] for fruit in fruits]) - spot
    along = way @ np.array([[cos(rotation), -sin(rotation)], [sin(rotation), cos(rotation)]])
    beyond = np.maximum(np.abs(along) - np.array(size) / 2, 0.0)
    return bool((np.hypot(*beyond.T) > [fruit.diameter / 2 + CLEAR for fruit in fruits]).all())


def _add(
    spec: Any, name: str, clutter: Clutter, size: tuple[float, float], at: list[float], rotation: float, colour: Array
) -> None:
    (x, y), orientation = (size[0] / 2, size[1] / 2), about_z(rotation)
    half, high = (x, y, THIN), 2 * THIN
    if clutter.shape == "stick":
        # A capsule lies along z: a quarter of a rotation about y lays it down.
        half, high = (y, max(x - y, 1e-3), 0.0), y
        orientation = product(orientation, np.array([cos(pi / 4), 0.0, sin(pi / 4), 0.0]))
    kinds: dict[str, Literal["ellipsoid", "box", "capsule"]] = {"leaf": "ellipsoid", "sheet": "box", "stick": "capsule"}
    place = {"pos": [*at[:2], at[2] + high], "quat": orientation.tolist()}
    add_geom(spec.worldbody, kinds[clutter.shape], name, size=half, rgba=[*colour, 1.0], **place, **UNTOUCHED)
