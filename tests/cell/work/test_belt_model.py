from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from layflat.cell import load
from layflat.cell.perception import Observation
from layflat.cell.plan.order import Fruit
from layflat.cell.work.belt_model import MAX_MISSES, BeltModel
from layflat.cell.work.world_model import OcclusionModel

CELL = load("belt")
BELT = CELL.conveyor
assert BELT is not None
AWAY = OcclusionModel(np.array([0.3, 0.29, 1.8]), np.array([[5.0, 5.0], [5.4, 5.0], [5.8, 5.0]]), 0.42, 0.08, 0.06)
STARTS = (-0.2, -0.5, -0.85, -1.2)  # of fruit on the belt, from its centre, m


def seen(way: float, time: float, rng: np.random.Generator, hidden: int | None = None) -> Observation:
    assert BELT is not None
    fruits = []
    for number, start in enumerate(STARTS):
        (x, y), *_ = (
            BELT.to_cell_frame(np.array([[start + way, 0.01 * number]])) + rng.normal(0.0, 3e-4, (1, 2))
        ).tolist()
        if BELT.holds(x, y) and number != hidden:
            fruits.append(Fruit(x, y, 0.06, "tomato", "first"))
    return Observation(time, tuple(fruits))


def watched(way: Callable[[float], float], until: float) -> BeltModel:
    assert BELT is not None
    model, rng = BeltModel(CELL, BELT), np.random.default_rng(1)
    for time in np.arange(0.0, until, 0.1).tolist():
        model.update(seen(way(time), time, rng), AWAY)
    return model


@pytest.mark.parametrize("speed", [0.1, 0.2, 0.4])
def test_the_speed_of_a_belt_is_found_from_what_lies_on_it(speed: float) -> None:
    model = watched(lambda t: speed * t, 1.5)
    assert model.is_speed_known
    assert model.speed == pytest.approx(speed, abs=4e-3)
    track = model.tracks[-1]
    start = STARTS[track.number - 1]
    assert model.position_along(track, 2.0) == pytest.approx(start + speed * 2.0, abs=4e-3)
    assert model.came == sum(start + speed * 1.4 > -0.38 for start in STARTS)


def test_a_belt_that_stops_is_found_to_rest() -> None:
    model = watched(lambda t: 0.2 * min(t, 1.0), 2.0)
    assert model.is_speed_known
    assert model.speed == pytest.approx(0.0, abs=3e-3)
    assert not watched(lambda t: 0.2 * min(t, 1.0), 1.25).is_speed_known


def test_a_belt_that_speeds_up_is_not_trusted_before_it_goes_on_steadily() -> None:
    def way(t: float) -> float:  # from rest to 0.4 m/s
        return 0.15 * t**2 if t < 4 / 3 else 0.4 * (t - 2 / 3)

    for until in (0.75, 1.0, 1.25, 1.5):
        assert not watched(way, until).is_speed_known
    model = watched(way, 2.3)
    assert model.is_speed_known
    assert model.speed == pytest.approx(0.4, abs=0.01)


def test_what_should_be_there_and_is_not_is_lost_and_what_the_arm_hides_is_not() -> None:
    assert BELT is not None
    for hides in (False, True):
        model, rng = watched(lambda t: 0.1 * t, 1.0), np.random.default_rng(2)
        (first, *_) = model.tracks
        fruit = model.fruit(first, 1.2)
        over = np.array([[0.0, 0.0], [fruit.x - 0.05, fruit.y], [fruit.x, fruit.y]])
        arm = OcclusionModel(np.array([0.3, 0.29, 1.8]), over, 0.42, 0.08, 0.06) if hides else AWAY
        for k in range(MAX_MISSES):
            model.update(seen(0.1 * (1.0 + 0.1 * k), 1.0 + 0.1 * k, rng, hidden=0), arm)
        assert (first in model.lost) is not hides
        assert (first in model.tracks) is hides
