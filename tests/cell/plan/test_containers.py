from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell.plan.order import Fruit, Packing
from tests.cell.plan.places import places

SMALL, LARGE = (0.04, 0.06), (0.05, 0.08)
PUNNET = places("punnet", (0.3, 0.1, 0.01), 0.08, (2, 3), *LARGE)
TRAY = places("tray", (0.3, -0.4, 0.0), 0.07, (3, 4), *SMALL)
SECOND = places("seconds", (0.5, -0.4, 0.0), 0.08, (1, 1), *LARGE, sort=("tomato", "B"))


def fruit(diameter: float = 0.055, kind: str = "tomato", grade: str = "A") -> Fruit:
    return Fruit(0.5, 0.0, diameter, kind, grade)


def test_the_place_that_is_least_too_large_is_taken() -> None:
    packing = Packing(PUNNET + TRAY)
    best = packing.best_place(fruit(0.055))
    assert best is not None
    assert best.container == "tray"
    larger = packing.best_place(fruit(0.065))
    assert larger is not None
    assert larger.key == ("punnet", "1-1")


@given(st.lists(st.sampled_from([0.045, 0.055, 0.07]), max_size=30))
def test_each_place_is_filled_once_by_what_it_takes_and_what_is_over_is_refused(diameters: list[float]) -> None:
    packing, refused = Packing(PUNNET + TRAY), 0
    for diameter in diameters:
        one = fruit(diameter)
        place = packing.best_place(one)
        if place is None:
            refused += 1
            assert packing.refusal_reason(one).startswith("every place that takes it is full")
            continue
        assert packing.refusal_reason(one) == ""
        packing = packing.filled(place, one)
    assert len(packing.contents) + refused == len(diameters)
    assert len(packing.contents) + len(packing.free) == 18
    filled = {place.key: place for place in packing.places}
    assert all(filled[key].accepts(one) for key, one in packing.contents.items())


def test_containers_fill_one_by_one_and_a_taken_place_is_refused() -> None:
    second = places("second", (0.5, 0.1, 0.0), 0.08, (2, 3), *LARGE)
    packing, one = Packing(PUNNET + second), fruit(0.07)
    for k in range(7):
        place = packing.best_place(one)
        assert place is not None
        assert place.container == ("punnet" if k < 6 else "second")
        packing = packing.filled(place, one)
    assert place is not None
    with pytest.raises(ValueError, match="is taken"):
        packing.filled(place, one)


@pytest.mark.parametrize(
    ("one", "reason"),
    [
        (fruit(kind="pear"), "no place takes kind 'pear'"),
        (fruit(grade="C"), "no place takes tomato of grade 'C'"),
        (fruit(0.09), "no place takes tomato of grade 'A' with 90 mm"),
        (fruit(0.045, grade="B"), "no place takes tomato of grade 'B' with 45 mm"),
    ],
)
def test_a_fruit_without_a_place_has_a_reason(one: Fruit, reason: str) -> None:
    packing = Packing(PUNNET + TRAY + SECOND)
    assert packing.best_place(one) is None
    assert packing.refusal_reason(one) == reason


def test_without_containers_there_is_no_place() -> None:
    assert Packing(()).refusal_reason(fruit()) == "there is no container"
