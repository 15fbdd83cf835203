"""Random clutter: leaves, labels and sticks between the fruit and on the table. It is seen, and touches nothing."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any, Literal

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.file.produce import Clutter
from layflat.cell.geometry import Array, about_z, overlap, product, rectangle
from layflat.cell.scene import shapes
from layflat.cell.scene.produce import SceneFruit

TRIES = 60  # to find room for a piece; one that finds none is left out
CLEAR = 1e-3  # between clutter and where fruit is laid, m: neither lies on the other
THIN = 2e-4  # half the thickness of leaves and sheets, m


def add_clutter(spec: Any, cell: Cell, fruits: list[SceneFruit], rng: np.random.Generator) -> None:
    """Add random pieces to a spec, half of them in trays, half on the table."""
    taken = cell.outlines
    for sort, clutter in cell.clutter.items():
        for i in range(int(rng.integers(clutter.count.least, clutter.count.most + 1))):
            factor, bright = np.clip(rng.normal(1.0, clutter.spread, 2), 0.4, 1.6)
            size = (factor * clutter.length, factor * clutter.width)
            for _ in range(TRIES):
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
    shapes.add(spec.worldbody, kinds[clutter.shape], name, size=half, rgba=[*colour, 1.0], **place, **shapes.UNTOUCHED)
