"""What travels between the processes of a run and of its page."""

import pickle
from collections import Counter
from math import isnan
from multiprocessing import get_context

import pytest

from layflat.pages.cell.snapshot import PickFigures, RunRequests, RunSnapshot, format_counts


def test_figures_of_deliveries_are_added() -> None:
    first = PickFigures(Counter(correct=3, lost=1), air=16.0, time=8.0, collisions=1)
    both = first + PickFigures(Counter(correct=2), air=6.0, time=4.0, false_detections=1)
    assert both == PickFigures(Counter(correct=5, lost=1), 22.0, 12.0, 1, 1)
    assert both.picks == 6
    assert both.picks_a_minute == 30.0
    assert both.air_each == pytest.approx(22.0 / 6.0)


def test_without_picks_nothing_is_known_of_them() -> None:
    assert PickFigures().picks == 0
    assert isnan(PickFigures().picks_a_minute)
    assert isnan(PickFigures().air_each)


def test_a_snapshot_travels() -> None:
    shot = RunSnapshot(pace=1.0, figures=PickFigures(Counter(correct=1), 4.0, 2.0), rows=(("1.1", "tomato"),))
    assert pickle.loads(pickle.dumps(shot)) == shot


def _ask(asked: RunRequests) -> None:
    asked.stop = asked.full_speed and not asked.stop


def test_what_is_asked_in_one_process_is_known_in_the_other() -> None:
    asked = RunRequests.shared()
    assert not asked.stop
    asked.full_speed = True
    process = get_context("spawn").Process(target=_ask, args=(asked,))
    process.start()
    process.join()
    assert asked.stop


def test_things_are_counted() -> None:
    assert format_counts(["tomato", "apple", "tomato"]) == "apple 1, tomato 2"
    assert format_counts([]) == "nothing"
