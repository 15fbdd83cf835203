"""Which fruit next, where to, and why the others are left.

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

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import hypot, sqrt

from layflat.cell.plan.fruit import Fruit
from layflat.cell.plan.packs import Packing, Spot
from layflat.cell.plan.reach import Angles, Posture, Reach

TravelTime = Callable[[Angles, Angles], float]
"""From one posture to another, s."""


@dataclass(frozen=True)
class Cup:
    """A suction cup, and what keeps it clear of fruit that it is not meant for.

    Args:
        radius: m.
        clearance: to every other fruit, m: as far as camera and arm may be off.
        overlap: by which fruit that touches may seem to overlap, m: diameters are seen with errors.
    """

    radius: float
    clearance: float = 3e-3
    overlap: float = 2e-3


@dataclass(frozen=True)
class Choice:
    """A fruit to be picked, the posture over it, the place it goes to, and the posture over that."""

    fruit: Fruit
    over_fruit: Posture
    spot: Spot
    over_spot: Posture
    travel: float
    """Time that the arm moves, to the fruit and on to the place, s."""


@dataclass(frozen=True)
class Left:
    """A fruit that is not picked now, and why, as one clause."""

    fruit: Fruit
    reason: str


@dataclass(frozen=True)
class Order:
    """What to do next: a choice, unless nothing can be picked, and what is left."""

    choice: Choice | None
    left: tuple[Left, ...]


def next_pick(
    fruits: Sequence[Fruit], packing: Packing, reach: Reach, here: Angles, cup: Cup, travel_time: TravelTime,
    *, least_confidence: float = 0.5, given_up: frozenset[Fruit] = frozenset(),
) -> Order:  # fmt: skip
    """The fruit to pick next: sure ones first, in steps of 0.1, and of these the one with the shortest way.

    Args:
        fruits: all that were seen; also those that are not picked stand in the way.
        packing: packs as they are filled by now.
        reach: of the arm.
        here: where the arm is, rad.
        cup: what picks.
        travel_time: of the arm.
        least_confidence: below it a fruit is left.
        given_up: tried too often.
    """
    choices, left = [], []
    for fruit in fruits:
        if fruit in given_up:
            found: Choice | str = "was tried too often"
        elif fruit.confidence < least_confidence:
            found = f"is not sure enough: {fruit.confidence:.2f} is below {least_confidence:.2f}"
        elif fruit.doubt:
            found = fruit.doubt
        else:
            others = [other for other in fruits if other is not fruit]
            found = _blocked(fruit, others, cup) or _way(fruit, packing, reach, here, travel_time)
        if isinstance(found, Choice):
            choices.append(found)
        else:
            left.append(Left(fruit, found))
    best = min(choices, key=lambda choice: (-round(choice.fruit.confidence, 1), choice.travel), default=None)
    return Order(best, tuple(left))


def cup_room(fruit: Fruit, other: Fruit, cup: Cup) -> float:
    """Between the cup on a fruit and another fruit, m; infinite where the other is too low to be met."""
    rim = fruit.radius + sqrt(max(fruit.radius**2 - cup.radius**2, 0.0))
    if rim >= other.diameter:
        return float("inf")
    above = max(rim - other.radius, 0.0)
    width = sqrt(other.radius**2 - above**2)
    return hypot(other.x - fruit.x, other.y - fruit.y) - cup.radius - width


def lift_room(fruit: Fruit, other: Fruit) -> float:
    """Between a fruit that is lifted and another that is higher, m; infinite where the other is no higher."""
    if other.radius <= fruit.radius:
        return float("inf")
    return hypot(other.x - fruit.x, other.y - fruit.y) - fruit.radius - other.radius


def _blocked(fruit: Fruit, others: Sequence[Fruit], cup: Cup) -> str:
    """Why a fruit's neighbours keep it from being picked; empty where they don't."""
    if cup.radius > fruit.radius:
        return f"is too small for the cup: {1e3 * fruit.diameter:.0f} mm"
    for other in others:
        short = cup.clearance - cup_room(fruit, other, cup)
        if short > 0.0:
            return f"the cup would come {1e3 * short:.0f} mm too close to {other.kind} at {_spot(other)}"
        short = -cup.overlap - lift_room(fruit, other)
        if short > 0.0:
            return (
                f"would drag {other.kind} at {_spot(other)}, which is over it by {1e3 * (short + cup.overlap):.0f} mm"
            )
    return ""


def _way(fruit: Fruit, packing: Packing, reach: Reach, here: Angles, travel_time: TravelTime) -> Choice | str:
    """Postures over a fruit and over its place, or why there are none."""
    over_fruit = reach.choose(fruit.x, fruit.y, lambda angles: travel_time(here, angles))
    if over_fruit is None:
        return f"is out of reach by {1e3 * reach.missing(fruit.x, fruit.y):.0f} mm"
    spot = packing.best(fruit)
    if spot is None:
        return packing.refusal(fruit)
    place = spot.place
    over_spot = reach.choose(place.x, place.y, lambda angles: travel_time(over_fruit.angles, angles))
    if over_spot is None:
        short = 1e3 * reach.missing(place.x, place.y)
        return f"its place {place.name} of {spot.pack} is out of reach by {short:.0f} mm"
    travel = travel_time(here, over_fruit.angles) + travel_time(over_fruit.angles, over_spot.angles)
    return Choice(fruit, over_fruit, spot, over_spot, travel)


def _spot(fruit: Fruit) -> str:
    return f"({fruit.x:.3f}, {fruit.y:.3f}) m"
