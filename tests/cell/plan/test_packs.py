from math import radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell.plan.fruit import Fruit
from layflat.cell.plan.packs import Packing, Takes, grid

TOMATO = frozenset({"tomato"})
SMALL = Takes(TOMATO, frozenset({"A"}), 0.04, 0.06)
LARGE = Takes(TOMATO, frozenset({"A", "B"}), 0.05, 0.08)
PUNNET = grid("punnet", (0.3, 0.1, 0.01), (0.07, 0.08), (2, 3), LARGE)
TRAY = grid("tray", (0.3, -0.4, 0.0), (0.07, 0.07), (3, 4), SMALL)


def fruit(diameter: float = 0.055, kind: str = "tomato", grade: str = "A") -> Fruit:
    return Fruit(0.5, 0.0, diameter, kind, grade)


def test_a_grid_lies_where_it_was_put_and_turns_about_its_first_place() -> None:
    assert len(PUNNET.places) == 6
    assert len(TRAY.places) == 12
    last = PUNNET.places[-1]
    assert last.name == "2-3"
    assert (last.x, last.y, last.z) == pytest.approx((0.37, 0.26, 0.01))
    turned = grid("turned", (0.3, 0.1, 0.0), (0.07, 0.08), (2, 3), LARGE, radians(90)).places[-1]
    assert (turned.x, turned.y) == pytest.approx((0.3 - 0.16, 0.1 + 0.07))


def test_the_place_that_is_least_too_large_is_taken() -> None:
    packing = Packing((PUNNET, TRAY))
    best = packing.best(fruit(0.055))
    assert best is not None
    assert best.pack == "tray"
    larger = packing.best(fruit(0.065))
    assert larger is not None
    assert (larger.pack, larger.place.name) == ("punnet", "1-1")


@given(st.lists(st.sampled_from([0.045, 0.055, 0.07]), max_size=30))
def test_each_place_is_filled_once_by_what_it_takes_and_what_is_over_is_told(diameters: list[float]) -> None:
    packing, refused = Packing((PUNNET, TRAY)), 0
    for diameter in diameters:
        one = fruit(diameter)
        spot = packing.best(one)
        if spot is None:
            refused += 1
            assert packing.refusal(one).startswith("every place that takes it is full")
            continue
        assert packing.refusal(one) == ""
        packing = packing.filled(spot, one)
    assert len(packing.contents) + refused == len(diameters)
    assert len(packing.contents) + len(packing.free) == 18
    rules = {(pack.name, place.name): place.takes for pack in packing.packs for place in pack.places}
    assert all(rules[key].takes(one) for key, one in packing.contents.items())


def test_a_full_pack_is_told_the_next_is_begun_and_an_empty_one_takes_its_place() -> None:
    second = grid("second", (0.5, 0.1, 0.0), (0.07, 0.08), (2, 3), LARGE)
    packing, one = Packing((PUNNET, second)), fruit(0.07)
    for k in range(7):
        assert packing.full == (("punnet",) if k >= 6 else ())
        spot = packing.best(one)
        assert spot is not None
        assert spot.pack == ("punnet" if k < 6 else "second")
        packing = packing.filled(spot, one)
    assert spot is not None
    with pytest.raises(ValueError, match="is taken"):
        packing.filled(spot, one)
    assert packing.replaced("punnet").full == ()
    assert len(packing.replaced("punnet").contents) == 1


@pytest.mark.parametrize(
    ("one", "told"),
    [
        (fruit(kind="pear"), "no place takes kind 'pear'"),
        (fruit(grade="C"), "no place takes tomato of grade 'C'"),
        (fruit(0.09), "no place takes tomato of grade 'A' with 90 mm"),
        (fruit(0.045, grade="B"), "no place takes tomato of grade 'B' with 45 mm"),
    ],
)
def test_a_fruit_without_a_place_is_told_why(one: Fruit, told: str) -> None:
    packing = Packing((PUNNET, TRAY))
    assert packing.best(one) is None
    assert packing.refusal(one) == told


def test_without_packs_there_is_no_place() -> None:
    assert Packing(()).refusal(fruit()) == "there is no pack"
