"""Packs with their places, and which place for which fruit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, sin

from layflat.cell.plan.fruit import Fruit

ANY: frozenset[str] = frozenset()
"""In place of kinds or grades: all of them."""


@dataclass(frozen=True)
class Takes:
    """What may lie in a place; no kinds or grades means any.

    Args:
        kinds: of produce.
        grades: of quality.
        smallest: diameter, m.
        largest: diameter, m.
    """

    kinds: frozenset[str] = ANY
    grades: frozenset[str] = ANY
    smallest: float = 0.0
    largest: float = float("inf")

    def takes_kind(self, fruit: Fruit) -> bool:
        """Whether fruit of this kind may lie here."""
        return not self.kinds or fruit.kind in self.kinds

    def takes_grade(self, fruit: Fruit) -> bool:
        """Whether fruit of this kind and grade may lie here."""
        return self.takes_kind(fruit) and (not self.grades or fruit.grade in self.grades)

    def takes(self, fruit: Fruit) -> bool:
        """Whether the fruit may lie here."""
        return self.takes_grade(fruit) and self.smallest <= fruit.diameter <= self.largest


@dataclass(frozen=True)
class Place:
    """Where one fruit lies in a pack; `x` and `y` of its middle and the height `z` of its floor, m."""

    name: str
    x: float
    y: float
    z: float = 0.0
    takes: Takes = field(default_factory=Takes)


@dataclass(frozen=True)
class Pack:
    """A pack: its places, in the order in which they are filled."""

    name: str
    places: tuple[Place, ...]


def grid(
    name: str, corner: tuple[float, float, float], pitch: tuple[float, float], count: tuple[int, int],
    takes: Takes, turned: float = 0.0,
) -> Pack:  # fmt: skip
    """A pack of equal places in rows and columns, named "row-column" from 1.

    Args:
        name: of the pack.
        corner: middle of the first place, and height of its floor, m.
        pitch: from row to row and from column to column, m.
        count: rows and columns; rows go along x.
        takes: what every place takes.
        turned: by which the pack is turned about the first place, rad.
    """
    places = []
    for row in range(count[0]):
        for column in range(count[1]):
            along, across = row * pitch[0], column * pitch[1]
            x = corner[0] + along * cos(turned) - across * sin(turned)
            y = corner[1] + along * sin(turned) + across * cos(turned)
            places.append(Place(f"{row + 1}-{column + 1}", x, y, corner[2], takes))
    return Pack(name, tuple(places))


@dataclass(frozen=True)
class Spot:
    """A place in its pack."""

    pack: str
    place: Place


Key = tuple[str, str]
"""Names of a pack and of a place in it."""


@dataclass(frozen=True)
class Packing:
    """Packs and what lies in them; it never changes: `filled` and `replaced` give a new one.

    Args:
        packs: in the order in which they are filled.
        contents: what lies where.
    """

    packs: tuple[Pack, ...]
    contents: Mapping[Key, Fruit] = field(default_factory=dict)

    @property
    def free(self) -> list[Spot]:
        """All empty places, in order."""
        return [
            Spot(pack.name, place)
            for pack in self.packs
            for place in pack.places
            if (pack.name, place.name) not in self.contents
        ]

    @property
    def full(self) -> tuple[str, ...]:
        """Names of the packs that hold no more."""
        open_packs = {spot.pack for spot in self.free}
        return tuple(pack.name for pack in self.packs if pack.name not in open_packs)

    def best(self, fruit: Fruit) -> Spot | None:
        """The place that is least too large; of equal ones the first, so that a pack is full before the next one."""
        fits = [spot for spot in self.free if spot.place.takes.takes(fruit)]
        return min(fits, key=lambda spot: spot.place.takes.largest, default=None)

    def refusal(self, fruit: Fruit) -> str:
        """Why there is no place for a fruit, as one clause; empty where there is one."""
        if self.best(fruit) is not None:
            return ""
        rules = {place.takes for pack in self.packs for place in pack.places}
        if not rules:
            return "there is no pack"
        if not any(rule.takes_kind(fruit) for rule in rules):
            return f"no place takes kind {fruit.kind!r}"
        if not any(rule.takes_grade(fruit) for rule in rules):
            return f"no place takes {fruit.kind} of grade {fruit.grade!r}"
        if not any(rule.takes(fruit) for rule in rules):
            return f"no place takes {fruit.kind} of grade {fruit.grade!r} with {1e3 * fruit.diameter:.0f} mm"
        fitting = [pack.name for pack in self.packs if any(place.takes.takes(fruit) for place in pack.places)]
        return f"every place that takes it is full, in {', '.join(fitting)}"

    def filled(self, spot: Spot, fruit: Fruit) -> Packing:
        """The same with a fruit in a place.

        Raises:
            ValueError: something lies there already.
        """
        key = spot.pack, spot.place.name
        if key in self.contents:
            raise ValueError(f"place {spot.place.name} of {spot.pack} is taken")
        return Packing(self.packs, {**self.contents, key: fruit})

    def replaced(self, name: str) -> Packing:
        """The same with an empty pack in place of the one of this name."""
        return Packing(self.packs, {key: fruit for key, fruit in self.contents.items() if key[0] != name})
