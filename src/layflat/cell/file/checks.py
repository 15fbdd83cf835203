"""Whether a cell can be: parts that overlap, out of reach, of unknown kinds, too small, lifts too short."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from layflat.cell.file.parts import Pack, Tray
from layflat.cell.plan.reach import Reach
from layflat.machine import Machine

if TYPE_CHECKING:
    from layflat.cell.file.model import Cell

Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


def check(cell: Cell) -> None:
    """Refuse a cell that can't be.

    Raises:
        ValueError: one clear line for the first thing that is wrong.
    """
    _arm(cell)
    _kinds(cell)
    _network(cell)
    _markers(cell)
    _sizes(cell)
    _apart(cell)
    _in_reach(cell)
    _lifted(cell)


def _arm(cell: Cell) -> None:
    joints = list(cell.machine.joints)
    if len(joints) != 2 or cell.machine.arm.gravity != 0.0:
        raise ValueError(f"machine {cell.machine.name!r} is no level arm of two joints; take one such as 'paper-arm'")
    if set(cell.mount.home) != set(joints):
        raise ValueError(f"mount.home has {sorted(cell.mount.home)}; give an angle for each of {joints}")
    for name, joint in cell.machine.joints.items():
        if abs(cell.mount.home[name]) > joint.stops.working_stroke / 2:
            raise ValueError(f"mount.home.{name} is outside of the joint's working stroke")


def _kinds(cell: Cell) -> None:
    known = sorted(cell.produce)
    for name, tray in cell.tray.items():
        unknown = [kind for kind in tray.produce if kind not in cell.produce]
        if unknown:
            raise ValueError(f"tray.{name}.produce names the unknown kind {unknown[0]!r}; known are {known}")
    for name, pack in cell.pack.items():
        if pack.kind not in cell.produce:
            raise ValueError(f"pack.{name}.kind is the unknown kind {pack.kind!r}; known are {known}")
        if not cell.produce[pack.kind].known:
            raise ValueError(f"pack.{name}.kind {pack.kind!r} is not known to vision; set produce.{pack.kind}.known")
        grades = list(cell.produce[pack.kind].grade)
        if pack.grade not in grades:
            raise ValueError(f"pack.{name}.grade {pack.grade!r} is none of {pack.kind}; its grades are {grades}")


def _markers(cell: Cell) -> None:
    seen: dict[int, str] = {}
    board = cell.board
    held = range(board.first_id, board.first_id + board.columns * board.rows // 2)
    for name, marker in cell.base_markers.marker.items():
        if marker.number in seen:
            raise ValueError(
                f"base_markers.marker.{name}.number {marker.number} is that of {seen[marker.number]!r} too"
            )
        if marker.number in held and board.dictionary == cell.base_markers.dictionary:
            raise ValueError(
                f"base_markers.marker.{name}.number {marker.number} is one of the board's ({held[0]} to {held[-1]})"
            )
        seen[marker.number] = name


def _network(cell: Cell) -> None:
    if cell.network is not None and not Path(cell.network.file).is_file():
        raise ValueError(f"network.file: there is no {cell.network.file}; give the path of an ONNX file from here")


def _sizes(cell: Cell) -> None:
    for name, pack in cell.pack.items():
        kind = cell.produce[pack.kind]
        greatest = min(kind.grade[pack.grade].most, kind.diameter.most)
        if pack.layout.opening < greatest:
            raise ValueError(
                f"pack.{name} is too small: a place of {pack.layout.name!r} takes {1e3 * pack.layout.opening:.0f} mm, "
                f"{pack.kind} of grade {pack.grade!r} has up to {1e3 * greatest:.0f} mm"
            )
    for name, tray in cell.tray.items():
        for kind_name in tray.produce:
            if min(tray.size) < cell.produce[kind_name].diameter.most:
                raise ValueError(f"tray.{name} is too small for one {kind_name}")


def footprints(cell: Cell) -> dict[str, Array]:
    """Outlines on the table of all that stands on it, (4, 2) corners in m."""
    outlines = {f"tray.{name}": _tray_outline(tray) for name, tray in cell.tray.items()}
    outlines |= {
        f"pack.{name}": rectangle(pack.centre, pack.turn, pack.layout.size) for name, pack in cell.pack.items()
    }
    outlines |= {
        f"base_markers.marker.{name}": rectangle(marker.centre, marker.turn, marker.size)
        for name, marker in cell.base_markers.marker.items()
    }
    column = 2 * base_radius(cell.machine)
    outlines["the arm's column"] = rectangle((0.0, 0.0), 0.0, (column, column))
    return outlines


def base_radius(machine: Machine) -> float:
    """Radius of the column under the first joint, m: that of its hose's cylinder."""
    return next(iter(machine.joints.values())).cylinder.diameter / 2


def _tray_outline(tray: Tray) -> Array:
    return rectangle(tray.centre, tray.turn, (tray.size[0] + 2 * tray.wall, tray.size[1] + 2 * tray.wall))


def rectangle(centre: tuple[float, float], turn: float, size: tuple[float, float]) -> Array:
    """Corners of a turned rectangle, (4, 2) in m."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(size) / 2
    return placed(centre, turn, corners)


def placed(centre: tuple[float, float], turn: float, points: Array) -> Array:
    """Points given from a part's centre and along its axes, in the cell's frame, (n, 2) in m."""
    cos, sin = np.cos(turn), np.sin(turn)
    turned: Array = np.asarray(points) @ np.array([[cos, sin], [-sin, cos]]) + np.array(centre)
    return turned


def place_over(pack: Pack, x: float, y: float) -> int | None:
    """Number of the pack's place over which something is, None where it is over none."""
    way = placed((0.0, 0.0), -pack.turn, np.array([x, y]) - places(pack))
    over = (2.0 * np.abs(way) < pack.layout.pitch).all(axis=1)
    return int(np.argmax(over)) if over.any() else None


def within(tray: Tray, x: float, y: float) -> bool:
    """Whether a place is over a tray's floor."""
    along, across = placed((0.0, 0.0), -tray.turn, np.array([[x - tray.centre[0], y - tray.centre[1]]]))[0]
    return bool(abs(along) < tray.size[0] / 2 and abs(across) < tray.size[1] / 2)


def _apart(cell: Cell) -> None:
    outlines = footprints(cell)
    low = np.array(cell.table.centre) - np.array(cell.table.size) / 2
    high = low + np.array(cell.table.size)
    for name, outline in outlines.items():
        if (outline < low).any() or (outline > high).any():
            raise ValueError(f"{name} does not stand on the table; move it, or give a greater table.size")
    for (one, first), (other, second) in combinations(outlines.items(), 2):
        if overlap(first, second):
            raise ValueError(f"{one} and {other} overlap; move one of them")


def overlap(first: Array, second: Array) -> bool:
    """Whether two convex outlines overlap: no side of either has all of the other beyond it."""
    for outline in (first, second):
        sides = np.roll(outline, -1, axis=0) - outline
        for side in sides:
            across = np.array([-side[1], side[0]])
            one, other = first @ across, second @ across
            if one.max() <= other.min() or other.max() <= one.min():
                return False
    return True


def _in_reach(cell: Cell) -> None:
    for name, tray in cell.tray.items():
        least = min(cell.produce[kind].diameter.least for kind in tray.produce)
        across = [np.linspace(-1, 1, 9) * (side - least) / 2 for side in tray.size]
        grid = np.stack(np.meshgrid(*across), axis=-1).reshape(-1, 2)
        _all_reached(cell, f"tray.{name}", placed(tray.centre, tray.turn, grid))
    for name, pack in cell.pack.items():
        _all_reached(cell, f"pack.{name}", places(pack))


def places(pack: Pack) -> Array:
    """Centres of a pack's places in the cell's frame, (n, 2) in m."""
    return placed(pack.centre, pack.turn, np.array(pack.layout.places))


def _all_reached(cell: Cell, name: str, points: Array) -> None:
    reach = Reach(cell.machine)
    for x, y in points.tolist():
        if (missing := reach.missing(x, y)) > 0.0:
            raise ValueError(
                f"{name} is out of the arm's reach by {max(1e3 * missing, 1.0):.0f} mm at x = {1e3 * x:.0f} mm, "
                f"y = {1e3 * y:.0f} mm (working strokes of {cell.machine.name!r}); move it"
            )


def tallest_fruit(cell: Cell) -> float:
    """Height of the tallest fruit that comes in any tray, m."""
    kinds = [cell.produce[kind] for tray in cell.tray.values() for kind in tray.produce]
    return max(kind.diameter.most * kind.flattening.most for kind in kinds)


def highest(cell: Cell) -> float:
    """Height over the table of all that the cup has to pass over: fruit in trays, and walls, m."""
    walls = [tray.height + tray.wall for tray in cell.tray.values()]
    walls += [pack.layout.height + pack.layout.wall for pack in cell.pack.values()]
    return max(tallest_fruit(cell) + max(tray.wall for tray in cell.tray.values()), *walls)


def _lifted(cell: Cell) -> None:
    kinds = {kind: cell.produce[kind] for tray in cell.tray.values() for kind in tray.produce}
    low = cell.lift.clearance - cell.lift.stroke
    for name, kind in kinds.items():
        lowest = kind.diameter.least * kind.flattening.least
        if low > lowest:
            raise ValueError(
                f"lift.stroke is too short: the cup comes down to {1e3 * low:.0f} mm, "
                f"a {name} is as low as {1e3 * lowest:.0f} mm"
            )
    tallest, over = tallest_fruit(cell), highest(cell)
    if cell.lift.clearance < tallest + over:
        raise ValueError(
            f"lift.clearance is too small: a fruit of {1e3 * tallest:.0f} mm must pass over {1e3 * over:.0f} mm; "
            f'give more than "{1e3 * (tallest + over):.0f} mm"'
        )
