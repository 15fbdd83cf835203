"""Fruit as a camera detected it, places in containers, what lies in them, and which place for which fruit."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from layflat.cell.file.model import Cell

Key = tuple[str, str]  # names of a container and of a place in it


@dataclass(frozen=True)
class Fruit:
    """One detected fruit, taken as a sphere that lies on the table."""

    x: float  # of its centre, m, in the frame of the arm's base
    y: float
    diameter: float  # m
    kind: str  # such as "tomato"
    grade: str  # such as "A"; empty where there is none
    confidence: float = 1.0  # that there is one, of this kind, 0 to 1
    doubt: str = ""  # why it has no grade, as a clause

    @property
    def radius(self) -> float:
        """Half its diameter, m."""
        return self.diameter / 2


@dataclass(frozen=True)
class Place:
    """Where one fruit lies in a container."""

    container: str
    name: str  # of the place in it, "row-column" from 1
    x: float  # of its middle, m
    y: float
    z: float = 0.0  # of its floor, m
    sort: tuple[str, str] = ("", "")  # kind and grade of what may lie here
    smallest: float = 0.0  # diameter, m
    largest: float = float("inf")

    @property
    def key(self) -> Key:
        """Names of the container and of the place."""
        return self.container, self.name

    def takes(self, fruit: Fruit) -> bool:
        """Return whether the fruit may lie here."""
        return self.sort == (fruit.kind, fruit.grade) and self.smallest <= fruit.diameter <= self.largest


@dataclass(frozen=True)
class Packing:
    """Places in the order in which they are filled, and what lies in them; `filled` gives a new one."""

    places: tuple[Place, ...]
    contents: Mapping[Key, Fruit] = field(default_factory=dict)

    @property
    def free(self) -> list[Place]:
        """All empty places, in order."""
        return [place for place in self.places if place.key not in self.contents]

    def best(self, fruit: Fruit) -> Place | None:
        """Return the place that is least too large; of equal ones the first, so that containers fill one by one."""
        fits = [place for place in self.free if place.takes(fruit)]
        return min(fits, key=lambda place: place.largest, default=None)

    def refusal(self, fruit: Fruit) -> str:
        """Return why there is no place for a fruit, as one clause; empty where there is one."""
        if self.best(fruit) is not None:
            return ""
        if not self.places:
            return "there is no container"
        sorts = {place.sort for place in self.places}
        if fruit.kind not in {kind for kind, _ in sorts}:
            return f"no place takes kind {fruit.kind!r}"
        if (fruit.kind, fruit.grade) not in sorts:
            return f"no place takes {fruit.kind} of grade {fruit.grade!r}"
        fitting = dict.fromkeys(place.container for place in self.places if place.takes(fruit))
        if not fitting:
            return f"no place takes {fruit.kind} of grade {fruit.grade!r} with {1e3 * fruit.diameter:.0f} mm"
        return f"every place that takes it is full, in {', '.join(fitting)}"

    def filled(self, place: Place, fruit: Fruit) -> Self:
        """Return the same with a fruit in a place; raise ValueError if something lies there already."""
        if place.key in self.contents:
            raise ValueError(f"place {place.name} of {place.container} is taken")
        return replace(self, contents={**self.contents, place.key: fruit})


def packing_of(cell: Cell) -> Packing:
    """Return all containers of a cell, empty; rows of places lie along a container's y axis."""
    places = []
    for name, container in cell.container.items():
        grade, layout = cell.produce[container.kind].grade[container.grade], container.layout
        for i, (x, y) in enumerate(container.places.tolist()):
            row, column = divmod(i, layout.columns)
            limits = (container.kind, container.grade), grade.least, min(grade.most, layout.opening)
            places.append(Place(name, f"{row + 1}-{column + 1}", x, y, layout.wall, *limits))
    return Packing(tuple(places))


def free_place_at(cell: Cell, packing: Packing, fruit: Fruit) -> Place | None:
    """Return the free place over which a fruit was seen; None where it is over none, or over one that is taken."""
    if (found := cell.place_at(fruit.x, fruit.y)) is None:
        return None
    place = [place for place in packing.places if place.container == found[0]][found[1]]
    return None if place.key in packing.contents else place
