from __future__ import annotations

import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.file.produce import Grade, TruncatedNormal


def test_a_spread_stays_between_its_ends_and_about_its_mean() -> None:
    spread = TruncatedNormal(mean=2.0, std=0.5, min=1.5, max=2.5)
    rng = np.random.default_rng(1)
    drawn = np.array([spread.draw(rng) for _ in range(4000)])
    assert drawn.min() >= 1.5
    assert drawn.max() <= 2.5
    assert drawn.mean() == pytest.approx(2.0, abs=0.02)


def test_a_spread_out_of_order_is_refused() -> None:
    with pytest.raises(ValueError, match="must lie between min 1"):
        TruncatedNormal(mean=3.0, std=0.5, min=1.5, max=2.5)


def test_a_grade_that_no_diameter_can_have_is_refused() -> None:
    with pytest.raises(ValueError, match="min must be below max"):
        Grade(min="60 mm", max="50 mm", colours=("red",))


def test_grades_go_by_diameter_and_colour(packing: Cell) -> None:
    tomato = packing.produce["tomato"]
    assert tomato.grade_of(0.060, "red") == "first"
    assert tomato.grade_of(0.045, "red") == "second"
    assert tomato.grade_of(0.060, "orange") == "unripe"
    assert tomato.grade_of(0.090, "red") is None
