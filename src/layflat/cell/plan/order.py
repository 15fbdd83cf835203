"""Order of picks: detected fruit, places in containers and their contents, and the choice of the next fruit.

A fruit is modelled as a sphere on the table. The cup comes from above and rests on it, and lifts it straight up:

| symbol | meaning | unit |
|---|---|---|
| R, R_n | radii of the fruit and of a neighbour | m |
| c | radius of the cup | m |
| h | height of the cup's rim on the fruit: R + sqrt(R^2 - c^2) | m |
| w | greatest radius of the neighbour at height h and above | m |

The cup passes a neighbour if their centres are c + w apart. The fruit passes it on the way up if they are R + R_n
apart, or if the neighbour is no higher: the distance between them then only grows.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import hypot, sqrt
from typing import NamedTuple, Self

from layflat.cell.file.model import Cell
from layflat.motion.planar import Angles, Configuration, PlanarReach

PlaceKey = tuple[str, str]  # names of a container and of a place in it
TravelTime = Callable[[Angles, Angles], float]  # from one configuration to another, s
CUP_CLEARANCE = 3e-3  # of the cup to all other fruit, m: greatest errors of camera and arm
OVERLAP_TOLERANCE = 2e-3  # apparent overlap of fruit that touches, by errors of diameters, m


@dataclass(frozen=True)
class Fruit:
    """Detected fruit, modelled as a sphere on the table."""

    x: float  # of its centre, m, in the frame of the arm's base
    y: float
    diameter: float  # m
    kind: str  # such as "tomato"
    grade: str  # such as "A"; empty where there is none
    confidence: float = 1.0  # that there is one, of this kind, 0 to 1
    ungraded_reason: str = ""  # why it has no grade, as a clause

    @property
    def radius(self) -> float:
        """Half its diameter, m."""
        return self.diameter / 2


@dataclass(frozen=True)
class ContainerPlace:
    """Place of one fruit in a container."""

    container: str
    name: str  # of the place in it, "row-column" from 1
    x: float  # of its middle, m
    y: float
    z: float = 0.0  # of its floor, m
    sort: tuple[str, str] = ("", "")  # kind and grade of the accepted fruit
    smallest: float = 0.0  # diameter, m
    largest: float = float("inf")

    @property
    def key(self) -> PlaceKey:
        """Names of the container and of the place."""
        return self.container, self.name

    def accepts(self, fruit: Fruit) -> bool:
        """Return whether the fruit has the kind, grade and diameter (limits included) of this place."""
        return self.sort == (fruit.kind, fruit.grade) and self.smallest <= fruit.diameter <= self.largest


@dataclass(frozen=True)
class Packing:
    """Places in the order in which they are filled, and their contents; immutable."""

    places: tuple[ContainerPlace, ...]
    contents: Mapping[PlaceKey, Fruit] = field(default_factory=dict)

    @property
    def free(self) -> list[ContainerPlace]:
        """All empty places, in order."""
        return [place for place in self.places if place.key not in self.contents]

    def best_place(self, fruit: Fruit) -> ContainerPlace | None:
        """Return the free place with the lowest upper limit of diameter that accepts a fruit (first of equals)."""
        candidates = [place for place in self.free if place.accepts(fruit)]
        return min(candidates, key=lambda place: place.largest, default=None)

    def refusal_reason(self, fruit: Fruit) -> str:
        """Return why there is no place for a fruit, as one clause; empty where there is one."""
        if self.best_place(fruit) is not None:
            return ""
        if not self.places:
            return "there is no container"
        sorts = {place.sort for place in self.places}
        if fruit.kind not in {kind for kind, _ in sorts}:
            return f"no place takes kind {fruit.kind!r}"
        if (fruit.kind, fruit.grade) not in sorts:
            return f"no place takes {fruit.kind} of grade {fruit.grade!r}"
        fitting = dict.fromkeys(place.container for place in self.places if place.accepts(fruit))
        if not fitting:
            return f"no place takes {fruit.kind} of grade {fruit.grade!r} with {1e3 * fruit.diameter:.0f} mm"
        return f"every place that takes it is full, in {', '.join(fitting)}"

    def filled(self, place: ContainerPlace, fruit: Fruit) -> Self:
        """Return a copy with a fruit in a place; raise ValueError if that is occupied."""
        if place.key in self.contents:
            raise ValueError(f"place {place.name} of {place.container} is taken")
        return replace(self, contents={**self.contents, place.key: fruit})


def empty_packing(cell: Cell) -> Packing:
    """Return the empty places of all containers of a cell; rows follow each other along its y axis."""
    places = []
    for name, container in cell.container.items():
        grade, layout = cell.produce[container.kind].grade[container.grade], container.layout
        for i, (x, y) in enumerate(container.places.tolist()):
            row, column = divmod(i, layout.columns)
            limits = (container.kind, container.grade), grade.min, min(grade.max, layout.opening)
            places.append(ContainerPlace(name, f"{row + 1}-{column + 1}", x, y, layout.wall, *limits))
    return Packing(tuple(places))


def free_place_at(cell: Cell, packing: Packing, fruit: Fruit) -> ContainerPlace | None:
    """Return the place that a detected fruit is over; None if it is over none, or `packing` has a fruit there already.

    Args:
        cell: cell with the containers.
        packing: places and their contents.
        fruit: detected fruit.
    """
    if (place_key := cell.place_at(fruit.x, fruit.y)) is None:
        return None
    container_place = [
        container_place for container_place in packing.places if container_place.container == place_key[0]
    ][place_key[1]]
    return None if container_place.key in packing.contents else container_place


class PickChoice(NamedTuple):
    """Fruit to be picked and its place, with the arm's configurations over both."""

    fruit: Fruit
    over_fruit: Configuration
    place: ContainerPlace
    over_place: Configuration
    travel: float  # travel time of the arm, to the fruit and on to the place, s


class NotPicked(NamedTuple):
    """Fruit that is not picked now, and the reason, as one clause."""

    fruit: Fruit
    reason: str


class PickSelection(NamedTuple):
    """Fruit to pick next, None where nothing can be picked, and reasons against each fruit that can't be picked."""

    choice: PickChoice | None
    not_picked: tuple[NotPicked, ...]


def choose_pick(
    fruits: Sequence[Fruit], packing: Packing, reach: PlanarReach, here: Angles, cup: float, travel_time: TravelTime,
    *, least_confidence: float = 0.5, given_up: frozenset[Fruit] = frozenset(),
) -> PickSelection:  # fmt: skip
    """Choose the fruit to pick next: by the highest confidence in steps of 0.1, then by the shortest travel.

    Args:
        fruits: all detected fruit; those that are not picked are obstacles.
        packing: places and their contents.
        reach: inverse kinematics of the arm.
        here: joint angles of the arm, rad.
        cup: radius of the cup, m.
        travel_time: between two configurations, s, or another measure, which is then that of `PickChoice.travel`.
        least_confidence: below which a fruit is not picked.
        given_up: fruit that is not tried again.
    """
    plan_fruit = partial(_plan_pick, packing=packing, reach=reach, here=here, travel_time=travel_time)
    return select_pick(fruits, cup, plan_fruit, least_confidence=least_confidence, given_up=given_up)


def select_pick(
    fruits: Sequence[Fruit], cup: float, plan_fruit: Callable[[Fruit], PickChoice | str], *, least_confidence: float,
    given_up: frozenset[Fruit],
) -> PickSelection:  # fmt: skip
    """Choose the fruit to pick next, as `choose_pick`, with a function that plans each pick.

    Args:
        fruits: all detected fruit.
        cup: radius of the cup, m.
        plan_fruit: returns the pick of a fruit, or the reason against it as a clause.
        least_confidence: below which a fruit is not picked.
        given_up: fruit that is not tried again.
    """
    choices, not_picked = [], []
    for fruit in fruits:
        if fruit in given_up:
            plan: PickChoice | str = "was tried too often"
        elif fruit.confidence < least_confidence:
            plan = f"is not sure enough: {fruit.confidence:.2f} is below {least_confidence:.2f}"
        elif fruit.ungraded_reason:
            plan = fruit.ungraded_reason
        else:
            others = [other for other in fruits if other is not fruit]
            plan = _blocking_reason(fruit, others, cup) or plan_fruit(fruit)
        if isinstance(plan, PickChoice):
            choices.append(plan)
        else:
            not_picked.append(NotPicked(fruit, plan))
    best = min(choices, key=lambda choice: (-round(choice.fruit.confidence, 1), choice.travel), default=None)
    return PickSelection(best, tuple(not_picked))


def cup_room(fruit: Fruit, other: Fruit, cup: float) -> float:
    """Return the clearance between the cup on a fruit and another fruit, m; infinite where that is too low to touch.

    It is negative where they would overlap.

    Args:
        fruit: under the cup.
        other: its neighbour.
        cup: radius of the cup, m.
    """
    rim = fruit.radius + sqrt(max(fruit.radius**2 - cup**2, 0.0))
    if rim >= other.diameter:
        return float("inf")
    above = max(rim - other.radius, 0.0)
    width = sqrt(other.radius**2 - above**2)
    return hypot(other.x - fruit.x, other.y - fruit.y) - cup - width


def lift_room(fruit: Fruit, other: Fruit) -> float:
    """Return the clearance between a lifted fruit and a higher neighbour, m; infinite where that is no higher.

    It is negative where the fruit would drag the neighbour.
    """
    if other.radius <= fruit.radius:
        return float("inf")
    return hypot(other.x - fruit.x, other.y - fruit.y) - fruit.radius - other.radius


def _blocking_reason(fruit: Fruit, others: Sequence[Fruit], cup: float) -> str:
    """Return the reason why cup or neighbours prevent a pick, as one clause; empty where they don't."""
    if cup > fruit.radius:
        return f"is too small for the cup: {1e3 * fruit.diameter:.0f} mm"
    for other in others:
        name = f"{other.kind} at ({other.x:.3f}, {other.y:.3f}) m"
        short = CUP_CLEARANCE - cup_room(fruit, other, cup)
        if short > 0.0:
            return f"the cup would come {1e3 * short:.0f} mm too close to {name}"
        short = -OVERLAP_TOLERANCE - lift_room(fruit, other)
        if short > 0.0:
            return f"would drag {name}, which is over it by {1e3 * (short + OVERLAP_TOLERANCE):.0f} mm"
    return ""


def _plan_pick(
    fruit: Fruit, packing: Packing, reach: PlanarReach, here: Angles, travel_time: TravelTime
) -> PickChoice | str:
    """Return the pick of a fruit with its configurations, or the reason why there is none."""
    over_fruit = reach.choose_configuration(fruit.x, fruit.y, lambda angles: travel_time(here, angles))
    if over_fruit is None:
        return f"is out of reach by {1e3 * reach.distance_outside(fruit.x, fruit.y):.0f} mm"
    place = packing.best_place(fruit)
    if place is None:
        return packing.refusal_reason(fruit)
    over_place = reach.choose_configuration(place.x, place.y, lambda angles: travel_time(over_fruit.angles, angles))
    if over_place is None:
        short = 1e3 * reach.distance_outside(place.x, place.y)
        return f"its place {place.name} of {place.container} is out of reach by {short:.0f} mm"
    travel = travel_time(here, over_fruit.angles) + travel_time(over_fruit.angles, over_place.angles)
    return PickChoice(fruit, over_fruit, place, over_place, travel)
