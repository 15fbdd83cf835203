"""Tables of holes: number, position, diameter, thread or fit, depth; mm."""

from __future__ import annotations

import re
from math import atan2, degrees
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from layflat.solids.component import Component
    from layflat.solids.drawings.flat import FlatPart
    from layflat.solids.shapes import Drilled

FIT_GAP = 0.05  # between drawn diameters of a bore and its shaft or bush, mm
BOUGHT_IN_BORES = re.compile(r"\b(bush|bearing)\b")  # names of bought parts that are pressed into bores


class Fits(NamedTuple):
    """Diameters that fit others, mm."""

    shafts: tuple[float, ...] = ()  # of ground shafts h6
    bushes: tuple[float, ...] = ()  # outer, of bushes and bearings

    def of_bore(self, diameter: float) -> str:
        """Return the tolerance of a bore of a diameter (mm), or an empty text."""
        return "H7" if any(abs(one - diameter) <= FIT_GAP for one in (*self.shafts, *self.bushes)) else ""

    def nominal(self, diameter: float) -> float:
        """Return the size (mm) that a drawn diameter stands for: that of its counterpart."""
        return next((one for one in (*self.shafts, *self.bushes) if abs(one - diameter) <= FIT_GAP), diameter)


class HoleTable(NamedTuple):
    """Table with a row for each hole."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def fits_of(components: Iterable[Component]) -> Fits:
    """Return the fits of an assembly: of its shafts, bushes and bearings."""
    from layflat.solids.shapes import Turned  # noqa: PLC0415

    shafts: set[float] = set()
    bushes: set[float] = set()
    for one in components:
        if not isinstance(one.shape, Turned):
            continue
        radii = sorted({float(x) for x, _ in one.shape.outline.points()})
        if "h6" in one.designation.split():
            shafts.add(round(2 * radii[-1], 2))
        elif one.bought and BOUGHT_IN_BORES.search(one.name):
            # With a flange, the largest radius is the flange's.
            body = radii[-2] if "flange" in one.name or len(radii) > 2 else radii[-1]
            bushes.add(round(2 * body, 1))
    return Fits(tuple(sorted(shafts)), tuple(sorted(bushes)))


def hole_table(part: FlatPart, fits: Fits | None = None) -> HoleTable:
    """Return the table of a pattern's holes, those along its thickness first.

    Args:
        part: the pattern.
        fits: of the assembly; None: no tolerances.
    """
    return table_of(
        [(*hole.centre, None, hole.diameter, hole.thread, "through", "") for hole in part.holes]
        + [_drilled(hole, through=k in part.through) for k, hole in enumerate(part.drilled)],
        fits or Fits(),
    )


def drilled_table(holes: Sequence[Drilled], fits: Fits) -> HoleTable:
    """Return the table of the drilled holes of a turned part."""
    return table_of([_drilled(hole) for hole in holes], fits)


Row = tuple[float, float, float | None, float, str, str, str]


def _drilled(hole: Drilled, *, through: bool = False) -> Row:
    x, y, z = hole.start
    return x, y, z, hole.diameter, hole.thread, "through" if through else f"{hole.depth:.1f}", direction(hole)


def direction(hole: Drilled) -> str:
    """Return the direction of a hole, as an axis or an angle about z."""
    for name, value in zip("xyz", hole.direction, strict=True):
        if abs(value) > 1 - 1e-6:
            return f"{'+' if value > 0 else '-'}{name}"
    x, y, z = hole.direction
    return f"{degrees(atan2(y, x)):.2f}°" if abs(z) < 1e-6 else f"({x:.3f}, {y:.3f}, {z:.3f})"


def table_of(rows: Sequence[Row], fits: Fits) -> HoleTable:
    """Return a table; depth, height and direction are left out where all holes go through along z."""
    plain = all(row[2] is None for row in rows)
    head = (
        ("No.", "x", "y", "Ø", "thread, fit") if plain else ("No.", "x", "y", "z", "Ø", "thread, fit", "depth", "along")
    )
    lines = []
    for number, (x, y, z, diameter, thread, depth, along) in enumerate(rows, 1):
        size = (number_text(fits.nominal(diameter), 1), thread or fits.of_bore(diameter))
        at = (str(number), number_text(x), number_text(y))
        lines.append((*at, *size) if plain else (*at, "" if z is None else number_text(z), *size, depth, along))
    return HoleTable(head, tuple(lines))


def number_text(value: float, decimals: int = 2) -> str:
    """Return a size in mm without needless zeros or a negative zero."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in {"-0", ""} else text
