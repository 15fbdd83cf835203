"""Blanks of parts, and the list of lengths to cut from tube, bar, hose, strip and threaded rod; lengths in mm."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import ceil, sqrt
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.shapes import Lofted, Prism, Turned
from layflat.solids.standard.materials import material

if TYPE_CHECKING:
    from collections.abc import Iterable

    from layflat.arrays import Array
    from layflat.solids.component import Component
    from layflat.solids.loops import Loop
    from layflat.solids.shapes import Shape

KERF_WIDTH = 3.0  # width of a saw's cut, which each piece costs, mm
SCISSOR_STOCKS = ("layflat hose", "rubber hose", "webbing", "strip")  # stock that is cut without loss
SOLD_BY_LENGTH = re.compile(
    r"(tube|square tube|flat bar|round bar|ground bar|layflat hose|rubber hose|webbing|strip)\b"
)
THREADED_ROD = re.compile(r"(DIN 976-1 M[\d.]+) x ([\d.]+)( - .*)")
LAYERS_PATTERN = re.compile(r", (\d+) layers")
LENGTH_PATTERN = re.compile(r"([\d.]+) mm long")


@dataclass(frozen=True)
class Cut:
    """Lengths to cut from one stock."""

    stock: str
    material: str  # grade; empty if the stock's designation has it
    pieces: tuple[tuple[str, float, int], ...]  # name of the part, length (mm), number
    loss: float  # length that each piece costs beyond its own, mm

    @property
    def total(self) -> float:
        """Length to buy, mm, rounded up to whole ones."""
        return float(ceil(sum(number * (length + self.loss) for _, length, number in self.pieces) - 1e-6))


def outer_points(shape: Shape) -> Array:
    """Return points of a shape's own frame of which the box is that of the shape, mm, (n, 3)."""
    match shape:
        case Prism(outline, height):
            flat = outline.points()
            return np.vstack([np.column_stack([flat, np.full(len(flat), z)]) for z in (0.0, height)])
        case Turned(outline):
            radius, z = outline.points().T
            none = np.zeros_like(radius)
            return np.vstack([np.column_stack([s * radius, none, z]) for s in (1, -1)]
                             + [np.column_stack([none, s * radius, z]) for s in (1, -1)])  # fmt: skip
        case Lofted(sections):
            return np.vstack(sections)
        case _:
            return np.vstack([at.origin + outer_points(piece) @ at.axes.T for piece, at in shape.placed()])


def extents(shape: Shape) -> tuple[float, float, float]:
    """Return the overall sizes of a shape, mm: along its own axes, or an outline's longest side where that is less."""
    if isinstance(shape, Prism):
        return *_flat_extents(shape.outline), shape.height
    x, y, z = np.ptp(outer_points(shape), axis=0)
    return float(x), float(y), float(z)


def _flat_extents(outline: Loop) -> tuple[float, float]:
    """Return the sizes of the smaller rectangle around an outline: along its axes, or along its longest side."""
    points = outline.points()
    sides = np.roll(points, -1, axis=0) - points
    x, y = sides[int(np.argmax(np.hypot(*sides.T)))]
    turned = points @ np.array([[x, -y], [y, x]]) / float(np.hypot(x, y))
    first, second = (tuple(map(float, np.ptp(one, axis=0))) for one in (points, turned))
    return min(first, second, key=lambda size: size[0] * size[1])  # type: ignore[return-value]


def strip_length(outline: Loop) -> float:
    """Return the length of the strip of which an outline is the bent edge, mm: P/2 = l + t, A = l t."""
    half = outline.perimeter / 2
    return (half + sqrt(max(half * half - 4 * outline.area, 0.0))) / 2


def blank_size(component: Component) -> str:
    """Return the overall size of a part's blank, mm: diameter and length of turned parts, flat size of bent ones.

    That of a part in several pieces is the stated one.
    """
    if not isinstance(component.shape, Prism | Turned | Lofted) and component.size:
        return component.size
    x, y, z = extents(component.shape)
    if isinstance(component.shape, Turned):
        return f"dia {_tenths(x)} x {_tenths(z)}"
    if isinstance(component.shape, Prism) and (component.making == "bending" or component.tags & {"hinge", "strap"}):
        return f"{_tenths(strip_length(component.shape.outline))} x {_tenths(z)}"
    return " x ".join(map(_tenths, sorted((x, y, z), reverse=True)))


def _tenths(size: float) -> str:
    return f"{round(size, 1):g}"


def list_cuts(components: Iterable[Component]) -> list[Cut]:
    """Return the lengths to cut for all components, by stock, in the order of the components."""
    found: dict[tuple[str, str], dict[tuple[str, float], int]] = {}
    for one in components:
        described = _describe_cut(one)
        if described is None:
            continue
        stock, grade, length, number = described
        pieces = found.setdefault((stock, grade), {})
        piece = (one.name, round(length, 1))
        pieces[piece] = pieces.get(piece, 0) + number
    return [
        Cut(stock, grade, tuple((name, length, number) for (name, length), number in pieces.items()),
            0.0 if stock.startswith(SCISSOR_STOCKS) else KERF_WIDTH)
        for (stock, grade), pieces in found.items()
    ]  # fmt: skip


def _describe_cut(component: Component) -> tuple[str, str, float, int] | None:
    """Return stock, grade, length (mm) and number of the pieces of a component; None if it is not cut to length."""
    rod = THREADED_ROD.match(component.designation)
    if rod:
        return rod[1] + rod[3], "", float(rod[2]), component.quantity
    if component.bought or not SOLD_BY_LENGTH.match(component.designation):
        return None
    layers = LAYERS_PATTERN.search(component.designation)
    stock, number = (
        LAYERS_PATTERN.sub("", component.designation),
        component.quantity * (int(layers[1]) if layers else 1),
    )
    stated = LENGTH_PATTERN.search(component.size)
    return stock, material(component.material).grade, float(stated[1]) if stated else _cut_length(component), number


def _cut_length(component: Component) -> float:
    """Return the length of a part of which the size does not state it, mm."""
    if isinstance(component.shape, Prism) and component.tags & {"hinge", "strap"}:
        return strip_length(component.shape.outline)
    sizes = extents(component.shape)
    return sizes[2] if isinstance(component.shape, Turned) else max(sizes)
