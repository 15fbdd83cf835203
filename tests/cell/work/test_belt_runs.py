"""Whole picks from a conveyor, with the scene's truth in place of a camera."""

from __future__ import annotations

import pytest

from layflat.cell.perception import Observation
from layflat.cell.plan.order import Fruit
from layflat.cell.plan.pick import PickOutcome
from layflat.cell.work.observer import Observer
from layflat.cell.work.results import PackingSummary
from layflat.cell.work.run import PackingRun, run_packing
from tests.cell.work.changed_cells import cell_with


class Chosen(Observer):
    """Notes what was chosen, and by which image."""

    def __init__(self) -> None:
        self.noted: list[tuple[Fruit, Observation]] = []

    def on_pick_start(self, fruit: Fruit, observation: Observation) -> None:
        self.noted.append((fruit, observation))


def run(speeds: list[list[str]], picks: int, count: int = 12, observer: Observer | None = None) -> PackingRun:
    changes = {
        "conveyor/speeds": speeds,
        "conveyor/count": {"min": count, "max": count},
        "conveyor/idle_timeout": "3 s",
    }
    return run_packing(cell_with(changes, of="belt"), 1, picks, None, observer or Observer())


@pytest.mark.parametrize(
    "speeds",
    [
        [["0 s", "0.4 m/s"]],
        [["0 s", "0.2 m/s"], ["3.5 s", "0 m/s"]],
        [["0 s", "0.3 m/s"], ["4 s", "-0.1 m/s"], ["6 s", "0.3 m/s"]],
    ],
    ids=["fast", "stops", "turns back"],
)
def test_what_moves_is_picked_and_laid_down(speeds: list[list[str]]) -> None:
    chosen = Chosen()
    found = run(speeds, 3, observer=chosen)
    figures = PackingSummary(found.deliveries)
    picks = [pick for delivery in found.deliveries for pick in delivery.picks]
    assert figures.correct >= 2
    assert figures.collisions == 0
    assert figures.release_error_worst_mm < 6.0
    assert len(chosen.noted) == len(picks)
    assert all(fruit in observation.fruits for fruit, observation in chosen.noted), "as it lay in that image"
    # What gets away is told; nothing is dropped.
    assert all(pick.trouble for pick in picks if pick.outcome is not PickOutcome.PLACED)
    assert not any(pick.outcome in {PickOutcome.LOST, PickOutcome.STUCK} for pick in picks)


def test_a_belt_on_which_nothing_comes_ends_the_run() -> None:
    found = run([["0 s", "0.2 m/s"]], 2, count=0)
    assert "nothing came on the conveyor" in str(found.error)
    assert found.deliveries[0].picks == ()


def test_what_passed_by_unpicked_is_told_with_the_reason() -> None:
    found = run([["0 s", "0.4 m/s"]], 6)
    (first, *_) = found.deliveries
    passed = {one.reason for one in first.not_picked} - {"no place takes apple of grade 'yellow'"}
    assert passed
    assert passed <= {
        "leaves the reach before it could be picked", "is not within reach yet", "has just come in sight",
        "does not come within reach",
    }  # fmt: skip
