"""Random clutter: leaves, labels and sticks between the fruit and on the table. It is seen, and touches nothing."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.cell.extras import mujoco
from layflat.cell.file.checks import footprints, overlap, placed, rectangle
from layflat.cell.file.clutter import Clutter
from layflat.cell.file.model import Cell
from layflat.cell.scene.produce import Fruit

Array = NDArray[np.float64]
TRIES = 60
"""To find room for a piece; one that finds none is left out."""
CLEAR = 1e-3
"""Between clutter and where fruit is laid, m: neither lies on the other."""
THIN = 2e-4
"""Half the thickness of leaves and sheets, m."""


def add_clutter(spec: Any, cell: Cell, fruits: list[Fruit], rng: np.random.Generator) -> None:
    """Add random pieces to a spec, half of them in trays, half on the table."""
    taken = footprints(cell)
    for sort, clutter in cell.clutter.items():
        for i in range(int(rng.integers(clutter.count.least, clutter.count.most + 1))):
            factor, bright = np.clip(rng.normal(1.0, clutter.spread, 2), 0.4, 1.6)
            size = (factor * clutter.length, factor * clutter.width)
            for _ in range(TRIES):
                spot, floor = _thrown(cell, taken, max(size), rng)
                turn = float(rng.uniform(0.0, pi))
                outline = rectangle((float(spot[0]), float(spot[1])), turn, size)
                on_table = floor == 0.0 and any(overlap(outline, other) for other in taken.values())
                if not on_table and _free(spot, turn, size, fruits):
                    colour = np.clip(bright * np.array(clutter.colour), 0.0, 1.0)
                    _add(spec, f"clutter.{sort}-{i}", clutter, size, [*spot, floor], turn, colour)
                    break


def _thrown(cell: Cell, taken: dict[str, Array], reach: float, rng: np.random.Generator) -> tuple[Array, float]:
    """A random spot on the floor of a tray, or on the table among the parts; and how high it is, m."""
    names = list(cell.tray)
    if names and rng.random() < 0.5:
        tray = cell.tray[names[int(rng.integers(len(names)))]]
        room = np.maximum(np.array(tray.size) - reach, 0.0) / 2
        return placed(tray.centre, tray.turn, rng.uniform(-room, room)), tray.wall
    corners = np.concatenate(list(taken.values()))
    return rng.uniform(corners.min(axis=0), corners.max(axis=0)), 0.0


def _free(spot: Array, turn: float, size: tuple[float, float], fruits: list[Fruit]) -> bool:
    """Whether a piece lies clear of where all fruit is laid."""
    if not fruits:
        return True
    way = np.array([fruit.position[:2] for fruit in fruits]) - spot
    along = way @ np.array([[cos(turn), -sin(turn)], [sin(turn), cos(turn)]])
    beyond = np.maximum(np.abs(along) - np.array(size) / 2, 0.0)
    return bool((np.hypot(*beyond.T) > [fruit.diameter / 2 + CLEAR for fruit in fruits]).all())


def _add(
    spec: Any, name: str, clutter: Clutter, size: tuple[float, float], at: list[float], turn: float, colour: Array
) -> None:
    types, (x, y) = mujoco().mjtGeom, (size[0] / 2, size[1] / 2)
    turned = [cos(turn / 2), 0.0, 0.0, sin(turn / 2)]
    half, kind = [x, y, THIN], {"leaf": types.mjGEOM_ELLIPSOID, "sheet": types.mjGEOM_BOX}.get(clutter.shape)
    if kind is None:
        # A capsule lies along z: a quarter turn about y lays it down.
        half, kind = [y, max(x - y, 1e-3), 0.0], types.mjGEOM_CAPSULE
        lying = np.array([cos(pi / 4), 0.0, sin(pi / 4), 0.0])
        turned = [
            turned[0] * lying[0], -turned[3] * lying[2], turned[0] * lying[2], turned[3] * lying[0],
        ]  # fmt: skip
    spec.worldbody.add_geom(
        name=name,
        type=kind,
        size=half,
        pos=[*at[:2], at[2] + (y if clutter.shape == "stick" else 2 * THIN)],
        quat=turned,
        rgba=[*colour, 1.0],
        contype=0,
        conaffinity=0,
    )
