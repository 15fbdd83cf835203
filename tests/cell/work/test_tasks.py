from __future__ import annotations

from math import cos, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.cell import Cell
from layflat.cell.plan.order import ContainerPlace, Fruit, PickChoice, empty_packing
from layflat.cell.plan.pick import PickTask
from layflat.cell.work.packer import centre_fruit, pick_rules, plan_task
from layflat.machine import load
from layflat.motion.planar import PlanarReach
from tests.cell.work.changed_cells import cell_with

ANGLES = st.tuples(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))


def choice(cell: Cell, fruit: Fruit) -> PickChoice:
    reach, place = PlanarReach(cell.machine), empty_packing(cell).best_place(fruit)
    assert place is not None
    over_fruit, over_place = reach.configurations(fruit.x, fruit.y)[0], reach.configurations(place.x, place.y)[0]
    return PickChoice(fruit, over_fruit, place, over_place, 0.5)


TOMATO = Fruit(0.48, 0.27, 0.060, "tomato", "first")
MUSHROOM = Fruit(0.48, 0.27, 0.045, "mushroom", "first")


def test_the_cup_passes_over_the_tallest_fruit_and_comes_down_on_this_one(packing: Cell) -> None:
    tallest = packing.produce["apple"].diameter.max * packing.produce["apple"].flattening.max
    for fruit in (TOMATO, MUSHROOM):
        task = plan_task(packing, choice(packing, fruit))
        top = packing.tray["infeed"].wall + packing.produce[fruit.kind].flattening.mean * fruit.diameter
        assert task.passing > packing.tray["infeed"].wall + tallest
        assert top - 6e-3 < task.fruit_height < top
        assert task.carrying - fruit.diameter >= task.passing - fruit.diameter * 0.1
        assert task.carrying <= packing.lift.clearance


def test_a_fruit_is_let_go_just_over_the_floor_of_its_place(packing: Cell) -> None:
    task = plan_task(packing, choice(packing, TOMATO))
    hangs = 0.0555  # from the cup down, as the cup tells when it sits on the fruit
    seated = task.seated(packing.tray["infeed"].wall + hangs)
    floor = packing.container["tomatoes"].layout.wall
    assert seated.place_height - hangs - floor == pytest.approx(2e-3)


def test_vacuums_tell_an_open_cup_from_a_closed_one(packing: Cell) -> None:
    for cell in (packing, cell_with({"cup/vacuum": "0.4 bar", "cup/open_leak": "30 ms"})):
        rules, cup = pick_rules(cell, PlanarReach(cell.machine)), cell.cup
        opened = cup.vacuum / (1 + cup.build_up / cup.open_leak)
        closed = cup.vacuum / (1 + cup.build_up / cup.leak)
        assert rules.empty < 0.1 * opened
        assert opened < rules.lost_vacuum < rules.sound < closed


def test_places_are_those_of_the_scene(packing: Cell) -> None:
    places = empty_packing(packing).places
    assert {place.container for place in places} == set(packing.container)
    tomatoes = [place for place in places if place.container == "tomatoes"]
    assert [place.name for place in tomatoes] == ["1-1", "1-2", "1-3", "2-1", "2-2", "2-3"]
    assert [(place.x, place.y) for place in tomatoes] == list(map(tuple, packing.container["tomatoes"].places))
    apples = next(place for place in places if place.container == "apples")
    assert apples.accepts(Fruit(0, 0, 0.07, "apple", "first"))
    assert not apples.accepts(Fruit(0, 0, 0.07, "apple", "yellow"))
    assert not apples.accepts(Fruit(0, 0, 0.07, "tomato", "first"))


@given(ANGLES, ANGLES, st.tuples(st.floats(-0.004, 0.004), st.floats(-0.004, 0.004)))
def test_however_the_cup_sits_on_it_the_fruits_middle_comes_to_its_place(
    at: tuple[float, float], over: tuple[float, float], beside: tuple[float, float]
) -> None:
    """The cup is beside the fruit's middle in the frame of the last link, which it keeps."""
    arm = load("paper-arm")
    reach = PlanarReach(arm)

    def held(angles: tuple[float, ...]) -> tuple[float, float]:
        c, s = cos(sum(angles)), sin(sum(angles))
        x, y = reach.tip(angles)
        return x + c * beside[0] - s * beside[1], y + s * beside[0] + c * beside[1]

    place, (x, y) = ContainerPlace("punnet", "1-1", *reach.tip(over)), held(at)
    task = PickTask(at, over, 0.06, 0.05, 0.06, 0.1, 0.15)
    found = centre_fruit(task, Fruit(x, y, 0.06, "tomato", "first"), place, at, reach)
    assert held(found.over_place) == pytest.approx((place.x, place.y), abs=1e-4)
