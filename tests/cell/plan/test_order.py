from math import hypot, inf, sqrt

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from layflat.cell.plan.order import Fruit, Packing, choose_pick, cup_room, lift_room
from layflat.machine import load
from layflat.motion.planar import Angles, PlanarReach
from tests.cell.plan.places import places

REACH = PlanarReach(load("paper-arm-fast"))
PACKING = Packing(places("tray", (0.35, 0.3, 0.0), 0.07, (1, 3)))
CUP = 0.012  # radius, m
HOME = (0.0, 0.0)


def seen(x: float, y: float, diameter: float = 0.06, confidence: float = 0.95, kind: str = "tomato") -> Fruit:
    return Fruit(x, y, diameter, kind, "A", confidence)


def travel_time(start: Angles, end: Angles) -> float:
    return max(abs(a - b) for a, b in zip(start, end, strict=True))


def reason(fruits: list[Fruit], of: Fruit) -> str:
    left = choose_pick(fruits, PACKING, REACH, HOME, CUP, travel_time).not_picked
    return next((one.reason for one in left if one.fruit is of), "")


def test_sure_fruit_comes_first_then_the_shortest_way() -> None:
    far, near = seen(0.6, 0.3, confidence=0.95), seen(0.5, 0.4, confidence=0.97)
    unsure = seen(0.4, 0.4, confidence=0.7)
    order = choose_pick([unsure, far, near], PACKING, REACH, HOME, CUP, travel_time)
    assert order.choice is not None
    assert order.choice.fruit is min((far, near), key=_way)
    assert order.not_picked == ()
    assert REACH.tip(order.choice.over_fruit.angles) == pytest.approx((order.choice.fruit.x, order.choice.fruit.y))
    place = order.choice.place
    assert REACH.tip(order.choice.over_place.angles) == pytest.approx((place.x, place.y))
    assert order.choice.travel == pytest.approx(_way(order.choice.fruit))


def _way(fruit: Fruit) -> float:
    over = REACH.configurations(fruit.x, fruit.y)[0].angles
    place = PACKING.places[0]
    return travel_time(HOME, over) + travel_time(over, REACH.configurations(place.x, place.y)[0].angles)


def test_what_can_not_be_picked_is_left_with_a_reason() -> None:
    away, unsure, pear = seen(1.0, 0.0), seen(0.5, 0.4, confidence=0.3), seen(0.6, 0.3, kind="pear")
    tiny, good = seen(0.4, 0.5, diameter=0.02), seen(0.3, 0.5)
    order = choose_pick([away, unsure, pear, tiny, good], PACKING, REACH, HOME, CUP, travel_time)
    assert order.choice is not None
    assert order.choice.fruit is good
    told = {one.fruit: one.reason for one in order.not_picked}
    assert told[away] == f"is out of reach by {1e3 * REACH.distance_outside(1.0, 0.0):.0f} mm"
    assert told[unsure] == "is not sure enough: 0.30 is below 0.50"
    assert told[pear] == "no place takes kind 'pear'"
    assert told[tiny] == "is too small for the cup: 20 mm"
    again = choose_pick([good], PACKING, REACH, HOME, CUP, travel_time, given_up=frozenset({good}))
    assert again.choice is None
    assert again.not_picked[0].reason == "was tried too often"
    assert choose_pick([], PACKING, REACH, HOME, CUP, travel_time).choice is None


def test_a_place_out_of_reach_and_full_containers_are_told() -> None:
    one = seen(0.5, 0.4)
    beyond = Packing(places("far", (1.2, 0.0, 0.0), 0.1, (1, 1)))
    (left,) = choose_pick([one], beyond, REACH, HOME, CUP, travel_time).not_picked
    assert left.reason.startswith("its place 1-1 of far is out of reach by ")
    full = PACKING
    while (place := full.best_place(one)) is not None:
        full = full.filled(place, one)
    (left,) = choose_pick([one], full, REACH, HOME, CUP, travel_time).not_picked
    assert left.reason == "every place that takes it is full, in tray"


def test_touching_fruit_of_one_size_can_be_picked() -> None:
    assert choose_pick([seen(0.5, 0.4), seen(0.56, 0.4)], PACKING, REACH, HOME, CUP, travel_time).not_picked == ()


def test_a_small_fruit_beside_a_large_one_waits_until_it_is_gone() -> None:
    small, large = seen(0.5, 0.4, 0.03), seen(0.5 + 2 * sqrt(0.015 * 0.04), 0.4, 0.08)
    assert "too close to tomato" in reason([small, large], small)
    assert reason([small, large], large) == ""
    assert choose_pick([small], PACKING, REACH, HOME, CUP, travel_time).not_picked == ()


def test_fruit_under_another_would_drag_it() -> None:
    """A cup that is small beside its fruit finds room, but the fruit does not."""
    slim = 0.004
    low, high = seen(0.5, 0.4, 0.05), seen(0.555, 0.4, 0.066)
    left = choose_pick([low, high], PACKING, REACH, HOME, slim, travel_time).not_picked
    assert [one.reason for one in left] == ["would drag tomato at (0.555, 0.400) m, which is over it by 3 mm"]


SIZES = st.floats(0.03, 0.09)


@given(SIZES, SIZES, st.floats(0.02, 0.12))
def test_rooms_are_those_between_solid_bodies(own: float, others: float, away: float) -> None:
    """The cup as a disk that comes down along the fruit's axis, and the fruit as a ball that goes up along it."""
    fruit, other = seen(0.0, 0.0, own), seen(away, 0.0, others)
    assume(away >= 2 * sqrt(fruit.radius * other.radius))  # they lie beside each other
    rim = fruit.radius + sqrt(fruit.radius**2 - CUP**2)
    heights = np.linspace(rim, rim + 0.2, 4001)
    widths = np.sqrt(np.maximum(other.radius**2 - (heights - other.radius) ** 2, 0.0))
    met = widths > 0.0
    expected = away - CUP - widths.max() if met.any() else inf
    if met.any() or cup_room(fruit, other, CUP) == inf:
        assert cup_room(fruit, other, CUP) == pytest.approx(expected, abs=1e-4)
    nearest = min(hypot(away, lift + fruit.radius - other.radius) for lift in np.linspace(0.0, 0.2, 2001))
    gap = nearest - fruit.radius - other.radius
    if lift_room(fruit, other) >= 0.0:
        assert gap >= -1e-6
    else:
        assert gap < 1e-6
