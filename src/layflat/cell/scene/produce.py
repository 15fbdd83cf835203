"""Random fruit: what each is, and where in its tray it is laid."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, pi, sin

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Tray
from layflat.cell.geometry import Array, about_z, product
from layflat.errors import CellError

CAP = 0.72  # height of a mushroom's cap as a share of its whole height
STEM = 0.2  # radius of a mushroom's stem per diameter of its cap
TRIES = 400
GAP = 2e-3  # between fruit that does not touch, m, at least


@dataclass(frozen=True)
class Specimen:
    """What a fruit is, whatever happens to it: lengths in m, mass in kg."""

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

    @property
    def under(self) -> float:
        """From its middle (that of a mushroom's cap) down to its lowest point, m."""
        return self.height - self.over

    @property
    def over(self) -> float:
        """From its middle up to its top, m."""
        return self.height / 2 if self.shape == "round" else CAP * self.height / 2


def fruit_of(cell: Cell, rng: np.random.Generator) -> list[SceneFruit]:
    """Draw random fruit for all trays; raise CellError if one has no room for as many as are drawn."""
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
    return found


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
