"""What came of picks in words."""

from __future__ import annotations

from dataclasses import replace
from math import nan

from layflat.cell.perception import Observation
from layflat.cell.plan.containers import Fruit, Place
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import Outcome
from layflat.cell.work.records import Delivery, Pick, Verdict, VisionErrors
from layflat.cell.work.tables import COLUMNS, known, not_picked, row, sort, summary, trouble
from layflat.motion.reach import Posture
from tests.cell.work.changed_cells import cell_with

TOMATO = Fruit(0.4, 0.3, 0.0567, "tomato", "first")
OVER = Posture((0.1, 0.2), 0.0)
CHOICE = Choice(TOMATO, OVER, Place("tomatoes", "1-2", 0.3, 0.4), OVER, 1.0)
DONE = Pick(4, CHOICE, Outcome.PLACED, "", 1, 2.0, 3.85, 3.94, Observation(2.0, ()))
RIGHT = Verdict("fruit 3", "tomato", "first", True, 1.14e-3, 22.6, 9.6)


def test_a_pick_is_a_row() -> None:
    said = dict(zip(COLUMNS, row("2.4", DONE, RIGHT), strict=True))
    assert list(said.values()) == [
        "2.4", "tomato, first", "57", "tomatoes 1-2", "correct", "1.1", "23", "1.85", "3.9"
    ]  # fmt: skip
    assert row("2.4", DONE, replace(RIGHT, correct=False))[4] == "wrong"
    assert row("2.4", DONE, Verdict())[5:7] == ("", "")


def test_what_went_wrong_is_said() -> None:
    assert trouble("2.4", DONE) == ""
    lost = replace(DONE, outcome=Outcome.LOST, trouble="the vacuum was lost", tries=2)
    assert trouble("2.4", lost) == "pick 2.4, lost, 2 tries: the vacuum was lost"
    assert not_picked(["is full", "is green", "is full"]) == ["2 not picked: is full", "1 not picked: is green"]
    assert sort(replace(TOMATO, grade="")) == "tomato"


def test_a_run_is_summed_up() -> None:
    cell = cell_with({})
    assert summary(cell, []) == []
    seen = VisionErrors([0.3e-3], [0.004], 1)
    delivery = Delivery(0, (DONE, DONE), (RIGHT, Verdict()), (), (), 4.0, seen, 0)
    lines = summary(cell, [delivery])
    assert lines[:2] == [
        "1 of 2 picks correct: in the chosen place, of its kind and grade (50.0%)",
        "30.0 picks a minute, 3.9 normal litres of air each",
    ]
    assert lines[-1] == "vision: position off by 0.30 mm, diameter by 0.4% (95 %); 1 false detection"
    blind = replace(delivery, verdicts=(Verdict(), Verdict()), vision=VisionErrors())
    assert len(summary(cell, [blind])) == 3
    assert summary(cell, [blind])[2] == "0 collisions; 0 overlooked that could have been packed"


def test_numbers_that_are_not_known_are_left_out() -> None:
    assert known(nan, 2) == ""
    assert known(1.234, 2) == "1.23"
