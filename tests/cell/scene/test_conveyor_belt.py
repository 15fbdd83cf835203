from __future__ import annotations

import numpy as np
import pytest

from layflat.cell import load
from layflat.cell.scene import Scene

CELL = load("belt")


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene(CELL, 1)


def test_fruit_rides_the_belt_and_is_carried_away(scene: Scene) -> None:
    assert CELL.conveyor is not None
    assert scene.belt is not None
    assert [fruit.here for fruit in scene.truth().fruits.values()].count(True) == 0
    scene.step(1500)
    (first,) = [fruit for fruit in scene.truth().fruits.values() if fruit.here]
    scene.step(500)
    moved = scene.truth().fruits[first.name].position - first.position
    assert scene.belt.speed == pytest.approx(0.2)
    assert moved == pytest.approx([0.0, 0.1, 0.0], abs=2e-3)
    assert CELL.conveyor.holds(*first.position[:2])
    scene.step(5000)
    fruits = scene.truth().fruits
    assert not fruits[first.name].here
    assert sum(fruit.here for fruit in fruits.values()) >= 1
    assert max(fruit.peak_acceleration for fruit in fruits.values()) < 1.0  # to be laid down is no blow


def test_a_belt_stops_and_goes_back_with_what_lies_on_it() -> None:
    scene = Scene(CELL, 1)
    assert scene.belt is not None
    scene.step(2000)
    (name,) = [name for name, fruit in scene.truth().fruits.items() if fruit.here]
    scene.belt.speed_override = 0.0
    scene.step(2000)
    stopped = scene.truth().fruits[name].position
    scene.step(200)
    rested = scene.truth().fruits[name].position
    assert np.linalg.norm(rested - stopped) < 4e-3  # it may roll on a little
    scene.belt.speed_override = -0.2
    scene.step(1000)
    assert scene.truth().fruits[name].position[1] < rested[1] - 0.05
