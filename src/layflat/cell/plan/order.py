"""Which fruit next, where to, and why the others are not picked.

A fruit is taken for a sphere on the table. The cup comes from above and rests on it, and lifts it straight up:

| symbol | meaning | unit |
|---|---|---|
| R, R_n | radii of the fruit and of a neighbour | m |
| c | radius of the cup | m |
| h | height of the cup's rim on the fruit: R + sqrt(R^2 - c^2) | m |
| w | how wide the neighbour still is at height h and above | m |

The cup passes a neighbour if their centres are c + w apart. The fruit passes it on the way up if they are R + R_n
apart, or if the neighbour is no higher: the way between them then only grows.
"""

from collections.abc import Callable, Sequence
from functools import partial
from math import hypot, sqrt
from typing import NamedTuple

from layflat.cell.plan.containers import Fruit, Packing, Place
from layflat.motion.reach import Angles, Posture, Reach

TravelTime = Callable[[Angles, Angles], float]  # from one posture to another, s
GAP = 3e-3  # of the cup to every fruit that it is not meant for, m: as far as camera and arm may be off
OVERLAP = 2e-3  # by which fruit that touches may seem to overlap, m: diameters are measured with errors


class Choice(NamedTuple):
    """A fruit to be picked, the posture over it, the place it goes to, and the posture over that."""

    fruit: Fruit
    over_fruit: Posture
    place: Place
    over_place: Posture
    travel: float  # time that the arm moves, to the fruit and on to the place, s


class NotPicked(NamedTuple):
    """A fruit that is not picked now, and why, as one clause."""

    fruit: Fruit
    reason: str


class Selection(NamedTuple):
    """What to pick next, None where nothing can be picked, and why the others are not picked."""

    choice: Choice | None
    not_picked: tuple[NotPicked, ...]


def next_pick(
    fruits: Sequence[Fruit], packing: Packing, reach: Reach, here: Angles, cup: float, travel_time: TravelTime,
    *, least_confidence: float = 0.5, given_up: frozenset[Fruit] = frozenset(),
) -> Selection:  # fmt: skip
    """Return the fruit to pick next: sure ones first, in steps of 0.1, and of these the one with the shortest way.

    Of all `fruits` that were detected, those that are not picked stand in the way too. The arm is `here` (rad), and
    `cup` is its cup's radius (m).
    """
    way = partial(_way, packing=packing, reach=reach, here=here, travel_time=travel_time)
    return selected(fruits, cup, way, least_confidence=least_confidence, given_up=given_up)


def selected(
    fruits: Sequence[Fruit], cup: float, way: Callable[[Fruit], Choice | str], *, least_confidence: float,
    given_up: frozenset[Fruit],
) -> Selection:  # fmt: skip
    """Return the fruit to pick next, as `next_pick`, by the ways of getting there or the reasons against them."""
    choices, not_picked = [], []
    for fruit in fruits:
        if fruit in given_up:
            found: Choice | str = "was tried too often"
        elif fruit.confidence < least_confidence:
            found = f"is not sure enough: {fruit.confidence:.2f} is below {least_confidence:.2f}"
        elif fruit.doubt:
            found = fruit.doubt
        else:
            others = [other for other in fruits if other is not fruit]
            found = _blocked(fruit, others, cup) or way(fruit)
        if isinstance(found, Choice):
            choices.append(found)
        else:
            not_picked.append(NotPicked(fruit, found))
    best = min(choices, key=lambda choice: (-round(choice.fruit.confidence, 1), choice.travel), default=None)
    return Selection(best, tuple(not_picked))


def cup_room(fruit: Fruit, other: Fruit, cup: float) -> float:
    """Return the room between a cup (radius, m) on a fruit and another fruit, m; infinite where that is too low."""
    rim = fruit.radius + sqrt(max(fruit.radius**2 - cup**2, 0.0))
    if rim >= other.diameter:
        return float("inf")
    above = max(rim - other.radius, 0.0)
    width = sqrt(other.radius**2 - above**2)
    return hypot(other.x - fruit.x, other.y - fruit.y) - cup - width


def lift_room(fruit: Fruit, other: Fruit) -> float:
    """Return the room between a fruit that is lifted and another that is higher, m; infinite where it is no higher."""
    if other.radius <= fruit.radius:
        return float("inf")
    return hypot(other.x - fruit.x, other.y - fruit.y) - fruit.radius - other.radius


def _blocked(fruit: Fruit, others: Sequence[Fruit], cup: float) -> str:
    """Return why a fruit's neighbours keep it from being picked; empty where they don't."""
    if cup > fruit.radius:
        return f"is too small for the cup: {1e3 * fruit.diameter:.0f} mm"
    for other in others:
        name = f"{other.kind} at ({other.x:.3f}, {other.y:.3f}) m"
        short = GAP - cup_room(fruit, other, cup)
        if short > 0.0:
            return f"the cup would come {1e3 * short:.0f} mm too close to {name}"
        short = -OVERLAP - lift_room(fruit, other)
        if short > 0.0:
            return f"would drag {name}, which is over it by {1e3 * (short + OVERLAP):.0f} mm"
    return ""


def _way(fruit: Fruit, packing: Packing, reach: Reach, here: Angles, travel_time: TravelTime) -> Choice | str:
    """Return the postures over a fruit and over its place, or why there are none."""
    over_fruit = reach.choose(fruit.x, fruit.y, lambda angles: travel_time(here, angles))
    if over_fruit is None:
        return f"is out of reach by {1e3 * reach.missing(fruit.x, fruit.y):.0f} mm"
    place = packing.best(fruit)
    if place is None:
        return packing.refusal(fruit)
    over_place = reach.choose(place.x, place.y, lambda angles: travel_time(over_fruit.angles, angles))
    if over_place is None:
        short = 1e3 * reach.missing(place.x, place.y)
        return f"its place {place.name} of {place.container} is out of reach by {short:.0f} mm"
    travel = travel_time(here, over_fruit.angles) + travel_time(over_fruit.angles, over_place.angles)
    return Choice(fruit, over_fruit, place, over_place, travel)
