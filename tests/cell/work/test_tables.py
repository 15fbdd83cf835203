"""What came of picks in words."""

from __future__ import annotations

from dataclasses import replace
from math import nan

from layflat.cell.perception import Observation
from layflat.cell.plan.order import ContainerPlace, Fruit, PickChoice
from layflat.cell.plan.pick import PickOutcome
from layflat.cell.work.observer import Delivery, Pick, Verdict, VisionErrors
from layflat.cell.work.results import (
    COLUMNS,
    count_reasons,
    describe_trouble,
    format_finite,
    pick_row,
    sort_name,
    summary_lines,
)
from layflat.motion.planar import Configuration
from tests.cell.work.changed_cells import cell_with

TOMATO = Fruit(0.4, 0.3, 0.0567, "tomato", "first")
OVER = Configuration((0.1, 0.2), 0.0)
CHOICE = PickChoice(TOMATO, OVER, ContainerPlace("tomatoes", "1-2", 0.3, 0.4), OVER, 1.0)
DONE = Pick(4, CHOICE, PickOutcome.PLACED, "", 1, 2.0, 3.85, 3.94, Observation(2.0, ()))
RIGHT = Verdict("fruit 3", "tomato", "first", True, 1.14e-3, 22.6, 9.6)


def test_a_pick_is_a_row() -> None:
    said = dict(zip(COLUMNS, pick_row("2.4", DONE, RIGHT), strict=True))
    assert list(said.values()) == [
        "2.4", "tomato, first", "57", "tomatoes 1-2", "correct", "1.1", "23", "1.85", "3.9"
    ]  # fmt: skip
    assert pick_row("2.4", DONE, replace(RIGHT, correct=False))[4] == "wrong"
    assert pick_row("2.4", DONE, Verdict())[5:7] == ("", "")


def test_what_went_wrong_is_said() -> None:
    assert describe_trouble("2.4", DONE) == ""
    lost = replace(DONE, outcome=PickOutcome.LOST, trouble="the vacuum was lost", tries=2)
    assert describe_trouble("2.4", lost) == "pick 2.4, lost, 2 tries: the vacuum was lost"
    assert count_reasons(["is full", "is green", "is full"]) == ["2 not picked: is full", "1 not picked: is green"]
    assert sort_name(replace(TOMATO, grade="")) == "tomato"


def test_a_run_is_summed_up() -> None:
    cell = cell_with({})
    assert summary_lines(cell, []) == []
    seen = VisionErrors([0.3e-3], [0.004], 1)
    delivery = Delivery(0, (DONE, DONE), (RIGHT, Verdict()), (), (), 4.0, seen, 0)
    lines = summary_lines(cell, [delivery])
    assert lines[:2] == [
        "1 of 2 picks correct: in the chosen place, of its kind and grade (50.0%)",
        "30.0 picks a minute, 3.9 normal litres of air each",
    ]
    assert lines[-1] == "vision: position off by 0.30 mm, diameter by 0.4% (95 %); 1 false detection"
    blind = replace(delivery, verdicts=(Verdict(), Verdict()), vision=VisionErrors())
    assert len(summary_lines(cell, [blind])) == 3
    assert summary_lines(cell, [blind])[2] == "0 collisions; 0 overlooked that could have been packed"


def test_numbers_that_are_not_known_are_left_out() -> None:
    assert format_finite(nan, 2) == ""
    assert format_finite(1.234, 2) == "1.23"
