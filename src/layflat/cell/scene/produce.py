"""Random parts of a scene: fruit, its position in its tray, and clutter, which is visible and without contacts."""

from dataclasses import dataclass, replace
from math import cos, pi, sin
from typing import Any, Literal

import numpy as np

from layflat.arrays import Array
from layflat.cell.extras import NO_CONTACT, add_geom
from layflat.cell.file.model import Cell, Conveyor
from layflat.cell.file.parts import Tray
from layflat.cell.file.produce import Clutter
from layflat.cell.geometry import outlines_overlap, quaternion_product, rectangle_corners, rotation_about_z
from layflat.errors import CellError

CAP_HEIGHT_RATIO = 0.72  # of a mushroom's cap to the whole mushroom
STEM_RADIUS_RATIO = 0.2  # of a mushroom's stem to the diameter of its cap
LAYING_TRIES = 400  # to find a position for one fruit in a tray
FRUIT_GAP = 2e-3  # least gap between fruit that does not touch, m
CLUTTER_TRIES = 60  # to find a position for a piece; it is left out where there is none
CLUTTER_CLEARANCE = 1e-3  # between clutter and fruit, m: neither lies on the other
BELT_MARGIN = 10e-3  # of fruit to the sides of a belt, m
SHELF_HEIGHT = -0.35  # of the shelf under the table, over the table, m
SHELF_GRID = 15, 0.11  # fruit on the shelf: number in a row, and distance, m
CLUTTER_HALF_THICKNESS = 2e-4  # of leaves and sheets, m


@dataclass(frozen=True)
class Specimen:
    """Constant properties of a fruit: lengths in m, mass in kg."""

    name: str
    kind: str
    colour: str
    grade: str | None
    diameter: float
    height: float
    mass: float


@dataclass(frozen=True)
class SceneFruit(Specimen):
    """Fruit with its appearance and initial pose, its middle at `position` in the cell's frame, m."""

    rgb: tuple[float, float, float]
    shape: str
    top: str
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    # Of fruit that comes on a belt: the belt's travel at which it comes, and its offset from the belt's middle, m.
    comes: tuple[float, float] | None = None

    @property
    def height_below(self) -> float:
        """Height of its middle (that of a mushroom's cap) over its lowest point, m."""
        return self.height - self.height_above

    @property
    def height_above(self) -> float:
        """Height of its top over its middle, m."""
        return self.height / 2 if self.shape == "round" else CAP_HEIGHT_RATIO * self.height / 2


def draw_fruit(cell: Cell, rng: np.random.Generator) -> list[SceneFruit]:
    """Draw random fruit for all trays, or the conveyor; raise CellError if a tray has no room for it."""
    fruits: list[SceneFruit] = []
    for name, tray in cell.tray.items():
        count = int(rng.integers(tray.count.min, tray.count.max + 1))
        specimens = [_draw_specimen(cell, str(rng.choice(tray.produce)), len(fruits) + i, rng) for i in range(count)]
        diameters = [fruit.diameter for fruit in specimens]
        if (layout := next(filter(None, (_lay_fruit(diameters, tray, rng) for _ in range(20))), None)) is None:
            where = f"{cell.origin}: tray.{name}"
            raise CellError(f"has no room for {count} fruit", where=where, right="give a smaller count")
        positions, is_isolated = layout
        for fruit, point, upright_free in zip(specimens, tray.to_cell_frame(positions), is_isolated, strict=True):
            position = float(point[0]), float(point[1]), tray.wall + fruit.height_below + FRUIT_GAP
            orientation = _draw_orientation(cell.produce[fruit.kind].tilt if upright_free else 0.0, rng)
            fruits.append(replace(fruit, position=position, orientation=orientation))
    return fruits if cell.conveyor is None else _draw_belt_fruit(cell, cell.conveyor, rng)


def _draw_belt_fruit(cell: Cell, belt: Conveyor, rng: np.random.Generator) -> list[SceneFruit]:
    """Draw the fruit that comes on a belt, one after the other; it rests on the shelf until then."""
    fruits, travel = [], 0.0
    for number in range(int(rng.integers(belt.count.min, belt.count.max + 1))):
        fruit = _draw_specimen(cell, str(rng.choice(belt.produce)), number, rng)
        room = max(belt.size[1] / 2 - BELT_MARGIN - fruit.diameter / 2, 0.0)
        position = (*shelf_position(belt.centre, number), SHELF_HEIGHT + fruit.height_below + FRUIT_GAP)
        orientation = _draw_orientation(cell.produce[fruit.kind].tilt, rng)
        comes = travel, float(rng.uniform(-room, room))
        fruits.append(replace(fruit, position=position, orientation=orientation, comes=comes))
        travel += float(rng.uniform(*belt.spacing))
    return fruits


def shelf_position(centre: tuple[float, float], number: int) -> tuple[float, float]:
    """Return the position, m, of the fruit of a number on the shelf under the table, around a centre (m)."""
    row, column = divmod(number, SHELF_GRID[0])
    return centre[0] + (column - SHELF_GRID[0] // 2) * SHELF_GRID[1], centre[1] + (
        row - SHELF_GRID[0] // 2
    ) * SHELF_GRID[1]


def _draw_specimen(cell: Cell, kind: str, number: int, rng: np.random.Generator) -> SceneFruit:
    """Return a random fruit of a kind, with size, colour, grade and mass, at the origin."""
    produce = cell.produce[kind]
    diameter = produce.diameter.draw(rng)
    height = diameter * produce.flattening.draw(rng)
    shares = np.array([skin.fraction for skin in produce.colour.values()])
    colour = str(rng.choice(list(produce.colour), p=shares / shares.sum()))
    skin = produce.colour[colour]
    rgb = np.array(skin.rgb) * rng.normal(1.0, skin.std) + rng.normal(0.0, skin.std / 2, 3)
    red, green, blue = (float(channel) for channel in np.clip(rgb, 0.02, 0.98))
    if produce.shape == "round":
        volume = pi / 6 * diameter**2 * height
    else:
        stem = pi * (STEM_RADIUS_RATIO * diameter) ** 2 * (1 - CAP_HEIGHT_RATIO) * height
        volume = pi / 6 * diameter**2 * CAP_HEIGHT_RATIO * height + stem
    mass = produce.density.draw(rng) * volume
    return SceneFruit(
        f"{kind}-{number}", kind, colour, produce.grade_of(diameter, colour), diameter, height, mass,
        (red, green, blue), produce.shape, produce.top,
    )  # fmt: skip


def _lay_fruit(diameters: list[float], tray: Tray, rng: np.random.Generator) -> tuple[Array, list[bool]] | None:
    """Draw positions of fruit in a tray from its centre, (n, 2) m, and flags of fruit that touches no other.

    Return None where there is no room. Touching fruit is laid upright, as it would roll apart.
    """
    spots, is_isolated = np.zeros((0, 2)), [True] * len(diameters)
    for i, diameter in enumerate(diameters):
        apart = (np.array(diameters[:i]) + diameter) / 2
        room = (np.array(tray.size) - diameter) / 2 - 1e-3
        leans = i > 0 and rng.random() < tray.touching_fraction
        for _ in range(LAYING_TRIES):
            if leans:
                beside, angle = int(rng.integers(i)), rng.uniform(0.0, 2 * pi)
                spot = spots[beside] + (apart[beside] + 1e-4) * np.array([cos(angle), sin(angle)])
            else:
                spot = rng.uniform(-room, room)
            gaps = np.hypot(*(spots - spot).T) - apart
            if leans:
                gaps[beside] = np.inf
            if (np.abs(spot) <= room).all() and (gaps > FRUIT_GAP).all():
                spots = np.vstack([spots, spot])
                if leans:
                    is_isolated[i] = is_isolated[beside] = False
                break
        else:
            return None
    return spots, is_isolated


def _draw_orientation(max_tilt: float, rng: np.random.Generator) -> tuple[float, float, float, float]:
    """Draw a quaternion: any rotation about the vertical axis, then a tilt up to `max_tilt` (rad) in any direction."""
    rotation, tilt, direction = rng.uniform(0, 2 * pi), max_tilt * np.sqrt(rng.random()), rng.uniform(0, 2 * pi)
    tilted = np.array([cos(tilt / 2), sin(tilt / 2) * cos(direction), sin(tilt / 2) * sin(direction), 0.0])
    w, x, y, z = quaternion_product(tilted, rotation_about_z(rotation)).tolist()
    return w, x, y, z


def add_clutter(spec: Any, cell: Cell, fruits: list[SceneFruit], rng: np.random.Generator) -> None:
    """Add random pieces of clutter to a spec, each in a tray or on the table; one without room is left out.

    Args:
        spec: MjSpec.
        cell: description.
        fruits: fruit that the pieces keep clear of.
        rng: generator.
    """
    taken = cell.outlines
    for sort, clutter in cell.clutter.items():
        for i in range(int(rng.integers(clutter.count.min, clutter.count.max + 1))):
            factor, bright = np.clip(rng.normal(1.0, clutter.std, 2), 0.4, 1.6)
            size = (factor * clutter.length, factor * clutter.width)
            for _ in range(CLUTTER_TRIES):
                spot, floor = _draw_spot(cell, taken, max(size), rng)
                rotation = float(rng.uniform(0.0, pi))
                outline = rectangle_corners((float(spot[0]), float(spot[1])), rotation, size)
                on_table = floor == 0.0 and any(outlines_overlap(outline, other) for other in taken.values())
                if not on_table and _is_clear(spot, rotation, size, fruits):
                    colour = np.clip(bright * np.array(clutter.colour), 0.0, 1.0)
                    _add_piece(spec, f"clutter.{sort}-{i}", clutter, size, [*spot, floor], rotation, colour)
                    break


def _draw_spot(cell: Cell, taken: dict[str, Array], reach: float, rng: np.random.Generator) -> tuple[Array, float]:
    """Draw a position (m) on the floor of a tray, or on the table, maybe on a part; return it and its height, m.

    `reach` is the longest side of the piece, m: in a tray, it touches no wall.
    """
    names = list(cell.tray)
    if names and rng.random() < 0.5:
        tray = cell.tray[names[int(rng.integers(len(names)))]]
        room = np.maximum(np.array(tray.size) - reach, 0.0) / 2
        return tray.to_cell_frame(rng.uniform(-room, room)), tray.wall
    corners = np.concatenate(list(taken.values()))
    return rng.uniform(corners.min(axis=0), corners.max(axis=0)), 0.0


def _is_clear(spot: Array, rotation: float, size: tuple[float, float], fruits: list[SceneFruit]) -> bool:
    """Return whether a piece of a length and width, m, turned about z (rad), is clear of all fruit.

    It is if the gap is greater than `CLUTTER_CLEARANCE`.
    """
    if not fruits:
        return True
    vectors = np.array([fruit.position[:2] for fruit in fruits]) - spot
    along = vectors @ np.array([[cos(rotation), -sin(rotation)], [sin(rotation), cos(rotation)]])
    beyond = np.maximum(np.abs(along) - np.array(size) / 2, 0.0)
    return bool((np.hypot(*beyond.T) > [fruit.diameter / 2 + CLUTTER_CLEARANCE for fruit in fruits]).all())


def _add_piece(
    spec: Any, name: str, clutter: Clutter, size: tuple[float, float], at: list[float], rotation: float, colour: Array
) -> None:
    """Add a leaf, sheet or stick that lies on the height at[2], m, without contacts.

    `size` is its length and width, m; `rotation` is about z, rad; `colour` is RGB, 0 to 1.
    """
    (x, y), orientation = (size[0] / 2, size[1] / 2), rotation_about_z(rotation)
    half, high = (x, y, CLUTTER_HALF_THICKNESS), 2 * CLUTTER_HALF_THICKNESS
    if clutter.shape == "stick":
        # A capsule lies along z: a quarter of a rotation about y lays it down.
        half, high = (y, max(x - y, 1e-3), 0.0), y
        orientation = quaternion_product(orientation, np.array([cos(pi / 4), 0.0, sin(pi / 4), 0.0]))
    kinds: dict[str, Literal["ellipsoid", "box", "capsule"]] = {"leaf": "ellipsoid", "sheet": "box", "stick": "capsule"}
    place = {"pos": [*at[:2], at[2] + high], "quat": orientation.tolist()}
    add_geom(spec.worldbody, kinds[clutter.shape], name, size=half, rgba=[*colour, 1.0], **place, **NO_CONTACT)
