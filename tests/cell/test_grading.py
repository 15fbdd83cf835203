from __future__ import annotations

import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.perception import classify_fruit
from layflat.cell.vision import Detection


def seen(
    kind: str | None, diameter: float, rgb: tuple[float, ...], spot: tuple[float, float] = (0.5, 0.2)
) -> Detection:
    red, green, blue = (255.0 * channel for channel in rgb)
    return Detection(kind, (*spot, 0.03), diameter, (red, green, blue), 0.9, np.zeros((4, 2)))


def reason(cell: Cell, one: Detection) -> str:
    fruit = classify_fruit(cell, one)
    assert (fruit.x, fruit.y, fruit.diameter) == (*one.position[:2], one.diameter)
    assert (fruit.grade == "") == (fruit.ungraded_reason != "")
    return fruit.ungraded_reason


@pytest.mark.parametrize("light", [0.3, 1.0, 1.05])
def test_the_nearest_skin_decides_in_any_light(packing: Cell, light: float) -> None:
    for name, kind in packing.produce.items():
        for colour, skin in kind.colour.items():
            if kind.recognised:
                at = kind.diameter.mean
                fruit = classify_fruit(packing, seen(name, at, tuple(light * channel for channel in skin.rgb)))
                assert fruit.grade == kind.grade_of(at, colour)
                assert (fruit.kind, fruit.diameter, fruit.confidence) == (name, at, 0.9)


def test_skins_are_told_apart_as_far_as_they_are_spread(packing: Cell) -> None:
    rng = np.random.default_rng(0)
    for name, kind in packing.produce.items():
        for colour, skin in kind.colour.items() if kind.recognised else ():
            for _ in range(100):
                rgb = np.array(skin.rgb) * rng.normal(1.0, skin.std) + rng.normal(0.0, skin.std / 2, 3)
                fruit = classify_fruit(packing, seen(name, kind.diameter.mean, tuple(np.clip(rgb, 0.02, 0.98))))
                assert fruit.ungraded_reason or fruit.grade == kind.grade_of(kind.diameter.mean, colour)


def test_between_two_skins_there_is_no_grade(packing: Cell) -> None:
    tomato = packing.produce["tomato"].colour
    red, orange = (np.array(tomato[name].rgb) for name in ("red", "orange"))
    told = [
        classify_fruit(packing, seen("tomato", 0.06, tuple(red + share * (orange - red))))
        for share in np.linspace(0, 1, 41)
    ]
    course = [one.ungraded_reason or one.grade for one in told]
    assert list(dict.fromkeys(course)) == ["first", "could be red or orange", "could be orange or red", "unripe"]
    assert 4 <= sum(one.ungraded_reason != "" for one in told) <= 20


def test_too_near_to_a_limit_there_is_no_grade(packing: Cell) -> None:
    red = packing.produce["tomato"].colour["red"].rgb
    said = "is too near to a limit: 52.4 mm may be of grade second or first"
    assert reason(packing, seen("tomato", 0.0524, red)) == said
    assert classify_fruit(packing, seen("tomato", 0.0535, red)).grade == "first"
    orange = packing.produce["tomato"].colour["orange"].rgb
    assert classify_fruit(packing, seen("tomato", 0.0524, orange)).grade == "unripe"


def test_what_fits_no_grade_is_told(packing: Cell) -> None:
    green = packing.produce["apple"].colour["green"].rgb
    assert reason(packing, seen("apple", 0.055, green)) == "is of no grade: green, 55 mm"
    assert "of grade none or first" in reason(packing, seen("apple", 0.062, green))


def test_an_unknown_kind_stands_in_the_way_without_a_grade(packing: Cell) -> None:
    one = seen(None, 0.05, (0.4, 0.1, 0.3))
    assert reason(packing, one) == "is of no kind that is known here"
    assert classify_fruit(packing, one).kind == "unknown"


def test_each_place_of_a_pack_is_told(packing: Cell) -> None:
    for name, pack in packing.container.items():
        for number, (x, y) in enumerate(pack.places.tolist()):
            near = (x + 0.4 * pack.layout.pitch[0], y - 0.4 * pack.layout.pitch[1])
            assert packing.place_at(*near) == (name, number)
    assert packing.place_at(*packing.tray["infeed"].centre) is None
